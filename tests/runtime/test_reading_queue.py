import threading

from hypothesis import given
from hypothesis import strategies as st

from echogrid.runtime.reading_queue import ReadingQueue

from .fakes import echo


def test_readings_come_out_once_in_the_order_in_which_they_went_in() -> None:
    queue = ReadingQueue()
    queue.put((echo(1), echo(2)))
    queue.put((echo(3),))
    assert [reading.stamp_ns for reading in queue.drain()] == [1, 2, 3]
    assert queue.drain() == []


@given(st.lists(st.one_of(st.integers(0, 9), st.none()), max_size=40), st.integers(1, 8))
def test_none_is_lost_or_doubled_and_the_oldest_give_way(steps: list[int | None], most: int) -> None:
    queue = ReadingQueue(most)
    drained: list[int] = []
    overflow: list[int] = []
    count = 0
    for step in steps:
        if step is None:
            taken = queue.drain()
            assert len(taken) <= most
            overflow += [reading.stamp_ns for reading in queue.drain_overflow()]
            drained += [reading.stamp_ns for reading in taken]
            assert drained == sorted(drained)
        else:
            queue.put(tuple(echo(count + index) for index in range(step)))
            count += step
    overflow += [reading.stamp_ns for reading in queue.drain_overflow()]
    drained += [reading.stamp_ns for reading in queue.drain()]
    assert sorted(drained + overflow) == list(range(count))


def test_many_threads_may_put_while_one_drains_an_overflowing_queue() -> None:
    queue = ReadingQueue(4)
    start = threading.Barrier(4)

    def put(first: int) -> None:
        start.wait()
        for number in range(first, first + 3000):
            queue.put((echo(number),))

    threads = [threading.Thread(target=put, args=(first,)) for first in (0, 3000, 6000)]
    for thread in threads:
        thread.start()
    start.wait()
    seen = []
    while any(thread.is_alive() for thread in threads):
        seen += queue.drain() + queue.drain_overflow()
    for thread in threads:
        thread.join()
    seen += queue.drain() + queue.drain_overflow()
    assert sorted(reading.stamp_ns for reading in seen) == list(range(9000))
