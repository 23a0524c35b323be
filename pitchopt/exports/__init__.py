"""What other programs read: JSON, CSV, harmonics and motion files, as pure functions.

Every writer has a reader beside it, and files are written whole or not at all.
"""

from __future__ import annotations

from pitchopt.exports.aerodyn import BladeMotion, blade_motion, motion_files, read_motion_files
from pitchopt.exports.certificates import certificates_file, read_certificates
from pitchopt.exports.files import check_folder, write_files, write_whole
from pitchopt.exports.harmonics import Harmonics, harmonics, harmonics_csv, read_harmonics_csv
from pitchopt.exports.outb import outb_bytes, read_outb
from pitchopt.exports.profiles import (
    ProfileSet,
    profile_csv,
    profile_set,
    read_profile_csv,
    tradeoff_profiles,
)
from pitchopt.exports.records import (
    design_document,
    design_record,
    document_text,
    tradeoff_csv,
    tradeoff_document,
)
from pitchopt.exports.series import (
    TimeSeries,
    read_series_csv,
    read_series_npz,
    series_csv,
    series_npz,
    series_of,
)
from pitchopt.exports.several import (
    read_schedule_csv,
    schedule_csv,
    several_document,
    several_npz,
)

__all__ = [
    "BladeMotion",
    "Harmonics",
    "ProfileSet",
    "TimeSeries",
    "blade_motion",
    "certificates_file",
    "check_folder",
    "design_document",
    "design_record",
    "document_text",
    "harmonics",
    "harmonics_csv",
    "motion_files",
    "outb_bytes",
    "profile_csv",
    "profile_set",
    "read_certificates",
    "read_harmonics_csv",
    "read_motion_files",
    "read_outb",
    "read_profile_csv",
    "read_schedule_csv",
    "read_series_csv",
    "read_series_npz",
    "schedule_csv",
    "series_csv",
    "series_npz",
    "series_of",
    "several_document",
    "several_npz",
    "tradeoff_csv",
    "tradeoff_document",
    "tradeoff_profiles",
    "write_files",
    "write_whole",
]
