"""Live: samples in, contacts and estimates out, in real time; the page."""
