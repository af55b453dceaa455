"""The laboratory: what judges Palpate. Studies, conformance, fuzz, soak, benchmarks and the paper's items."""
