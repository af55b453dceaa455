"""Verification of the product: conformance of fixtures, fuzzing, soak runs and benchmarks."""
