"""Verification of the product: conformance, fuzzing, coverage of intervals, soak runs and benchmarks."""
