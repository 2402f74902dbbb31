"""Study of contact detection and stiffness estimates: data, splits, parts and report."""
