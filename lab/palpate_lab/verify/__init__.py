"""Verification of the product: conformance of fixtures, fuzzing, coverage of intervals, soak runs and benchmarks."""
