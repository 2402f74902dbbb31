"""What every registered thing must do, as functions for whoever writes one: plain asserts."""

from firstcontact.testing._detector import check_detector
from firstcontact.testing._estimator import check_estimator
from firstcontact.testing._hand import check_hand
from firstcontact.testing._policy import check_policy
from firstcontact.testing._source import check_source

__all__ = ["check_detector", "check_estimator", "check_hand", "check_policy", "check_source"]
