"""Live page: an output that shows the session in a browser."""

from firstcontact.core.installation import require_modules

require_modules("live", "websockets")
