"""Ports which move bytes, frames and transfers, and know no device."""
