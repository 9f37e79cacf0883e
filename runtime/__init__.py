"""The service: config, acquisition, fixed-rate loop, outputs, command line."""
