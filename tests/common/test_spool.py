"""What is put aside comes back as it was, from memory and from the disk; a disk without room is said in one line."""

from __future__ import annotations

import errno
import threading

import numpy as np
import pytest

from toolpace.common.errors import UsageError
from toolpace.common.files import Spool, spool


@pytest.mark.parametrize("in_memory", [1 << 25, 1000])
def test_objects_come_back_in_any_order_and_from_any_thread(monkeypatch, in_memory):
    monkeypatch.setattr(spool, "IN_MEMORY", in_memory)
    kept, arrays = Spool(), [np.arange(k, dtype=np.float64) for k in range(40)]
    threads = [
        threading.Thread(target=lambda part=part: [kept.put(k, (arrays[k], "words")) for k in range(part, 40, 3)])
        for part in range(3)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert kept.numbers() == list(range(40)) and 7 in kept and 40 not in kept
    for k in (39, 0, 17):
        array, words = kept.get(k)
        np.testing.assert_array_equal(array, arrays[k])
        assert words == "words"
    with pytest.raises(KeyError):
        kept.get(40)


def test_a_full_disk_is_said_with_its_cure(monkeypatch):
    kept = Spool()

    class Full:
        def seek(self, place):
            pass

        def write(self, data):
            raise OSError(errno.ENOSPC, "No space left on device")

    kept._file.close()
    monkeypatch.setattr(kept, "_file", Full())
    with pytest.raises(UsageError, match=r"temporary folder .*: cannot write: no space left on device; .* TMPDIR"):
        kept.put(0, 1)
