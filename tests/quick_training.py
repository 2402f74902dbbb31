"""Settings that make trainings in tests quick."""

from pkgutil import resolve_name

from stored_fits import FITS

#: Values by the full names of constants: two candidates of each search, detectors that learn from
#: 16 pinches, and two folds where folds choose a threshold or a conditioning scheme.
SETTINGS: dict[str, object] = {
    "firstcontact.models.windows.svm.C_GRID": (10.0,),
    "firstcontact.models.windows.svm.GAMMA_GRID": (0.3, 1.0),
    "firstcontact.models.windows.svm.EPSILON_GRID": (0.15,),
    "firstcontact.models.windows.log_spectrum.C_GRID": (0.1, 1.0),
    "firstcontact.models.rig.network_estimator.FOLDS": 2,
    "firstcontact.contact.logistic.PINCHES": 16,
    "firstcontact.contact.logistic.FOLDS": 2,
    "firstcontact.contact.svm.PINCHES": 16,
    "firstcontact.contact.svm.FOLDS": 2,
}
SETTINGS |= FITS


def train_quickly() -> None:
    """Apply the settings to this process, which runs a command or a script of a test.

    Tests of single models and detectors train with the shipped values, in `test_stiffness_svm.py`,
    `test_log_spectrum.py`, `test_combined.py` and `tests/contact`. Whole commands train with the
    shipped values in the slow test `test_shipped_detector_is_reproducible` and in `make quick`.
    """
    for name, value in SETTINGS.items():
        owner, _, constant = name.rpartition(".")
        setattr(resolve_name(owner), constant, value)
