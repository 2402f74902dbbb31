"""Commands of ``firstcontact_lab``, which entry points add to ``firstcontact``."""
