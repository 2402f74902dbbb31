"""Commands of ``firstcontact_lab``. Entry points add them to the command line."""
