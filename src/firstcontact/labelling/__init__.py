"""Labels by ear and eye: onsets that were found are confirmed on a page, into new recordings."""
