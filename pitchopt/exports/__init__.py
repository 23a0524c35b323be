"""What other programs read: JSON, CSV, harmonics and motion files, as pure functions.

Every writer has a reader beside it, and files are written whole or not at all.
"""

from __future__ import annotations

from pitchopt.exports.aerodyn import BladeMotion, blade_motion, motion_files, read_motion_files
from pitchopt.exports.certificates import certificates_file, read_certificates
from pitchopt.exports.files import check_folder, write_files, write_whole
from pitchopt.exports.harmonics import Harmonics, harmonics, harmonics_csv, read_harmonics_csv
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

__all__ = [
    "BladeMotion",
    "Harmonics",
    "ProfileSet",
    "blade_motion",
    "certificates_file",
    "check_folder",
    "design_document",
    "design_record",
    "document_text",
    "harmonics",
    "harmonics_csv",
    "motion_files",
    "profile_csv",
    "profile_set",
    "read_certificates",
    "read_harmonics_csv",
    "read_motion_files",
    "read_profile_csv",
    "tradeoff_csv",
    "tradeoff_document",
    "tradeoff_profiles",
    "write_files",
    "write_whole",
]
