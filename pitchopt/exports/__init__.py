"""What other programs read: JSON, CSV, harmonics, motion files, ROSCO input, as pure functions.

Every writer has a reader beside it, and files are written whole or not at all.
"""

from __future__ import annotations

from pitchopt.exports.aerodyn import BladeMotion, blade_motion, motion_files, read_motion_files
from pitchopt.exports.certificates import certificates_file, read_certificates
from pitchopt.exports.discon import changed_discon, discon_numbers, discon_value, read_discon
from pitchopt.exports.files import check_folder, write_files, write_whole
from pitchopt.exports.harmonics import Harmonics, harmonics, harmonics_csv, read_harmonics_csv
from pitchopt.exports.lead import ActuatorLag, led_command, truncated
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
from pitchopt.exports.rosco_ipc import IPCSection, discon_ipc, read_discon_ipc
from pitchopt.exports.rosco_open_loop import (
    OpenLoop,
    check_open_loop,
    open_loop,
    open_loop_discon,
    open_loop_file,
    open_loop_lines,
    read_open_loop,
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
    SeveralProfiles,
    read_schedule_csv,
    read_several_npz,
    schedule_csv,
    several_document,
    several_npz,
)

__all__ = [
    "ActuatorLag",
    "BladeMotion",
    "Harmonics",
    "IPCSection",
    "OpenLoop",
    "ProfileSet",
    "SeveralProfiles",
    "TimeSeries",
    "blade_motion",
    "certificates_file",
    "changed_discon",
    "check_folder",
    "check_open_loop",
    "design_document",
    "design_record",
    "discon_ipc",
    "discon_numbers",
    "discon_value",
    "document_text",
    "harmonics",
    "harmonics_csv",
    "led_command",
    "motion_files",
    "open_loop",
    "open_loop_discon",
    "open_loop_file",
    "open_loop_lines",
    "outb_bytes",
    "profile_csv",
    "profile_set",
    "read_certificates",
    "read_discon",
    "read_discon_ipc",
    "read_harmonics_csv",
    "read_motion_files",
    "read_open_loop",
    "read_outb",
    "read_profile_csv",
    "read_schedule_csv",
    "read_series_csv",
    "read_series_npz",
    "read_several_npz",
    "schedule_csv",
    "series_csv",
    "series_npz",
    "series_of",
    "several_document",
    "several_npz",
    "tradeoff_csv",
    "tradeoff_document",
    "tradeoff_profiles",
    "truncated",
    "write_files",
    "write_whole",
]
