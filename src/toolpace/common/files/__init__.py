"""Files and folders of results, written completely or not at all."""

from __future__ import annotations

from toolpace.common.files.atomic import file_to_write, reason, whole_file, write_text
from toolpace.common.files.folder import finished, folder_to_write, is_folder, whole_folder
from toolpace.common.files.free_space import free_disk, free_memory
from toolpace.common.files.seal import KEY as SEAL
from toolpace.common.files.seal import changed, sealed_files
from toolpace.common.files.spool import Spool

__all__ = [
    "SEAL", "Spool", "changed", "file_to_write", "finished", "folder_to_write", "free_disk", "free_memory", "is_folder",
    "reason", "sealed_files", "whole_file", "whole_folder", "write_text",
]  # fmt: skip
