"""Learning and being asked: splits, trainings, scores, and models that are kept."""
