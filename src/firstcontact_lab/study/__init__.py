"""Study of contact detection and stiffness estimates: data, splits, parts and report.

Terms of this package:

- A *split* divides pinches into a training side and a test side. A *fold* is one of several splits
  that together test every pinch once. *Out of fold*: from a model not trained on the pinch.
- A *question* states which pinches a competitor learns from, and which pinches it predicts.
- A *trigger* is a contact that a detector reports. The detector *places* it at one sample, and
  *decides* with a later sample.
- *Unseen objects* are the pinches of role ``test``. *Beyond the blocks*: on unseen objects, on
  another hand, or with a Shore A that was left out of training.
- A *rig set* holds the pinches of two simulated hands from one seed.
- A *real set* is a folder with real recordings, and perhaps noise and results of a study.
- A *hardness rank* orders materials whose Shore A is unknown. Materials with the same rank form a
  *hardness class*.
"""
