"""Groups run in turns: preparing, sampling, checking, the device's limits, the quality of what came out."""
