"""Files of certificates: what is read back is what was written, and checks the same."""

from __future__ import annotations

import numpy as np
import pytest

from pitchopt import load_case
from pitchopt.design import Certificate, ProofSettings, compared
from pitchopt.errors import InputError
from pitchopt.exports import certificates_file, read_certificates


@pytest.fixture(scope="module")
def task():
    case = load_case("biegel2011").with_values(
        {"limits.positions": 6, "limits.pitch_rate": np.radians(3.0)}
    )
    return case.task()


@pytest.fixture(scope="module")
def certificates(task) -> dict[str, Certificate]:
    tree = compared(task, mu=20.0, certify=ProofSettings(gap=2e-3, seconds=60.0, regions=200))
    hull = compared(task, max_power_loss=0.03)
    assert tree.design.certificate is not None and hull.design.certificate is not None
    assert tree.design.certificate.method == "branch and bound"
    assert hull.design.certificate.method == "hull relaxation"
    return {"mu=20": tree.design.certificate, "loss=3%": hull.design.certificate}


def test_round_trip(certificates, task, tmp_path) -> None:
    path = tmp_path / "certificates.npz"
    path.write_bytes(certificates_file(certificates))
    again = read_certificates(path)
    assert list(again) == list(certificates)
    raw = task.model.curves(task.positions)
    for label, certificate in certificates.items():
        read = again[label]
        assert read.method == certificate.method
        assert read.objective == certificate.objective and read.limits == certificate.limits
        want = pytest.approx(certificate.upper_bound, rel=1e-12)
        assert read.check() == want
        assert read.check(raw) == want  # the model's curves, limits applied anew
        assert read.check(task.problem().curves) == want
    assert again["mu=20"].curves is not certificates["mu=20"].curves


def test_other_curves_are_refused(certificates, task) -> None:
    raw = task.model.curves(task.positions)
    other = type(raw)(
        blades=3, azimuth=raw.azimuth, beta=raw.beta, torque=raw.torque * 1.001,
        bending=raw.bending, thrust=raw.thrust,
    )  # fmt: skip
    for certificate in certificates.values():
        with pytest.raises(InputError, match="other curves"):
            certificate.check(other)


def test_intervals_hold_what_is_better(certificates, task) -> None:
    found = compared(task, mu=20.0, certify=False).design
    certificate = certificates["mu=20"]
    intervals = certificate.intervals(found.objective * (1 - 1e-12))
    assert intervals is not None
    low, high = intervals
    assert np.all(low <= found.profile + 1e-12) and np.all(found.profile <= high + 1e-12)
    assert np.mean(high - low) < 0.9 * np.mean(certificate.curves.upper - certificate.curves.lower)
    assert certificate.intervals(2 * certificate.upper_bound) is None


@pytest.mark.parametrize("content", [b"", b"nonsense", b"PK\x03\x04broken"])
def test_broken_files(tmp_path, content) -> None:
    path = tmp_path / "certificates.npz"
    path.write_bytes(content)
    with pytest.raises(InputError, match="certificates"):
        read_certificates(path)
    with pytest.raises(InputError, match="certificates"):
        read_certificates(tmp_path / "none.npz")


def test_other_arrays(tmp_path, certificates) -> None:
    path = tmp_path / "other.npz"
    np.savez(path, format=np.array("something else"), labels=np.array(["x"]))
    with pytest.raises(InputError, match="something else"):
        read_certificates(path)
    path.write_bytes(certificates_file(certificates)[:-40])
    with pytest.raises(InputError, match="certificates"):
        read_certificates(path)
