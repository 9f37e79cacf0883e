"""Words in pictures: small letters, figures and some signs, of 5 x 9 pixels each."""

from collections.abc import Iterator

import numpy as np

from echogrid.mapping.metrics import Mask

HEIGHT = 9
_WIDTH = 6
"""A letter and the gap after it."""
_SIGNS = "abcdefghijkl", "mnopqrstuvwx", "yz0123456789", "-.,:+/()' "
_DRAWN = """\
      #               #         ##        #       #      #  #      ##
      #               #        #  #       #                 #       #
 ###  # ##   ###   ## #  ###   #     #### # ##   ##     ##  #  #    #
    # ##  # #   # #  ## #   # ###   #   # ##  #   #      #  # #     #
 #### #   # #     #   # #####  #    #   # #   #   #      #  ##      #
#   # #   # #   # #   # #      #     #### #   #   #      #  # #     #
 #### ####   ###   ####  ###   #        # #   #  ###     #  #  #   ###
                                        #             #  #
                                     ###               ##
                                           #
                                           #
## #  # ##   ###  ####   #### # ##   #### ###   #   # #   # #   # #   #
# # # ##  # #   # #   # #   # ##  # #      #    #   # #   # #   #  # #
# # # #   # #   # #   # #   # #      ###   #    #   # #   # # # #   #
# # # #   # #   # ####   #### #         #  #  # #  ##  # #  # # #  # #
# # # #   #  ###  #         # #     ####    ##   ## #   #    # #  #   #
                  #         #
                  #         #
             ###    #    ###  #####    #  #####   ##  #####  ###   ###
            #   #  ##   #   #    #    ##  #      #        # #   # #   #
#   # ##### #  ##   #       #   #    # #  ####  #        #  #   # #   #
#   #    #  # # #   #      #     #  #  #      # ####    #    ###   ####
#   #   #   ##  #   #     #       # #####     # #   #  #    #   #     #
 ####  #    #   #   #    #    #   #    #  #   # #   #  #    #   #    #
    # #####  ###   ###  #####  ###     #   ###   ###   #     ###   ##
    #
 ###
                                  #   #   #      #
                   ##     #       #  #     #     #
                   ##     #      #  #       #   #
#####                   #####   #   #       #
                          #    #    #       #
       ##    ##    ##     #   #      #     #
       ##    ##    ##         #       #   #
             #
            #
"""


def written(words: str, scale: int) -> Mask:
    """(rows, cols) the words on one line, row 0 on top. Raises KeyError for a letter that is not drawn."""
    drawn = np.concatenate([_LETTERS[letter] for letter in words.lower()], axis=1)
    return np.repeat(np.repeat(drawn, scale, axis=0), scale, axis=1)


def _letters() -> Iterator[tuple[str, Mask]]:
    lines = _DRAWN.splitlines()
    for index, signs in enumerate(_SIGNS):
        block = lines[HEIGHT * index : HEIGHT * (index + 1)]
        drawn = np.array([[pixel == "#" for pixel in line.ljust(_WIDTH * len(signs))] for line in block])
        for place, sign in enumerate(signs):
            yield sign, drawn[:, _WIDTH * place : _WIDTH * (place + 1)]


_LETTERS = dict(_letters())
