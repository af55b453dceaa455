"""What a run tells afterwards: the summary table and the HTML report."""
