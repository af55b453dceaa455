"""``palpate study demonstrations``: simulated operators palpate scenes by the hundred, straight into one data set."""
