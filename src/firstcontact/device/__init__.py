"""Devices: the wire protocol, and sources of samples behind one interface."""

from firstcontact.device.source import Arrival, Descriptor, Health, Source

__all__ = ["Arrival", "Descriptor", "Health", "Source"]
