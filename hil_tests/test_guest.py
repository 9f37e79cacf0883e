"""The guest's maker, as far as it can be looked at without one."""

import gzip
import lzma
import os
import stat
import struct
import subprocess
import sys
from pathlib import Path

from pytest import CaptureFixture, MonkeyPatch, fixture, mark, raises

from hil_tests.guest import __main__ as guest
from hil_tests.guest import cpio, packages
from hil_tests.guest.errors import GuestError
from hil_tests.guest.machine import NO_CODE, Machine, run
from hil_tests.guest.modules import loading_order
from hil_tests.guest.vmlinux import extract

ELF = b"\x7fELF and the rest"


def image(payload: bytes) -> bytes:
    """A compressed kernel: two sectors of set-up, then the payload."""
    head = bytearray(3 * 512 + 16)
    head[0x1F1] = 2
    struct.pack_into("<II", head, 0x248, 16, len(payload))
    return bytes(head) + payload + b"trailer"


@mark.parametrize("payload", [lzma.compress(ELF), gzip.compress(ELF)])
def test_the_plain_kernel_is_found(payload: bytes) -> None:
    assert extract(image(payload)) == ELF


@mark.parametrize("payload", [b"\x28\xb5\x2f\xfd", lzma.compress(b"no program")])
def test_what_is_no_plain_kernel_is_left_as_it_is(payload: bytes) -> None:
    assert extract(image(payload)) is None


def test_an_archive_is_what_cpio_reads(tmp_path: Path) -> None:
    whole = cpio.archive([cpio.folder("bin"), cpio.file("bin/tool", b"abc"), cpio.link("sh", "bin/tool")])
    names, modes, offset = [], [], 0
    while offset < len(whole):
        fields = [int(whole[offset + 6 + 8 * n : offset + 14 + 8 * n], 16) for n in range(13)]
        size, name_size = fields[6], fields[11]
        assert whole[offset : offset + 6] == b"070701"
        names.append(whole[offset + 110 : offset + 110 + name_size - 1].decode())
        modes.append(stat.S_IFMT(fields[1]))
        offset += -(-(110 + name_size) // 4) * 4
        offset += -(-size // 4) * 4
    assert names == ["bin", "bin/tool", "sh", "TRAILER!!!"]
    assert modes == [stat.S_IFDIR, stat.S_IFREG, stat.S_IFLNK, 0]


@fixture
def modules(tmp_path: Path) -> Path:
    """A kernel's modules: b needs a-x, which is packed; c is built in."""
    (tmp_path / "modules.dep").write_text("kernel/b.ko: kernel/a-x.ko.xz\nkernel/a-x.ko.xz:\n")
    (tmp_path / "modules.builtin").write_text("kernel/c.ko\n")
    (tmp_path / "kernel").mkdir()
    (tmp_path / "kernel" / "b.ko").write_bytes(b"B")
    (tmp_path / "kernel" / "a-x.ko.xz").write_bytes(lzma.compress(b"A"))
    return tmp_path


def test_modules_come_after_what_they_need(modules: Path) -> None:
    assert loading_order(modules, ("b", "c", "a_x")) == [("a_x.ko", b"A"), ("b.ko", b"B")]


def test_a_module_that_the_kernel_lacks_is_an_error(modules: Path) -> None:
    with raises(GuestError, match="srf99"):
        loading_order(modules, ("srf99",))


def test_a_package_that_does_not_exist_is_named() -> None:
    with raises(GuestError, match=r"cannot find no-such-package-at-all: .*Unable to locate"):
        packages.missing(["no-such-package-at-all"])


def test_without_a_guest_the_exit_code_says_so(
    monkeypatch: MonkeyPatch, capsys: CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr(sys, "argv", ["guest", "--", "true"])
    monkeypatch.setattr(guest, "require_qemu", lambda: None)
    monkeypatch.setenv("XDG_CACHE_HOME", f"{tmp_path}/file/below")
    (tmp_path / "file").touch()
    assert guest.main() == NO_CODE
    assert capsys.readouterr().err.startswith("no guest: ")


def test_a_guest_that_says_nothing_is_no_success(
    monkeypatch: MonkeyPatch, capsys: CaptureFixture[str], tmp_path: Path
) -> None:
    fake = tmp_path / "qemu-system-x86_64"
    fake.write_text("#!/bin/sh\necho no such machine\n")
    fake.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    machine = Machine(tmp_path, tmp_path, tmp_path, tmp_path)
    assert run(machine, ["true"], 10.0) == NO_CODE
    assert "no such machine" in capsys.readouterr().err


def test_the_first_process_is_a_script_that_the_shell_understands() -> None:
    script = Path(guest.__file__).with_name("init.sh")
    subprocess.run(["sh", "-n", script], check=True)
