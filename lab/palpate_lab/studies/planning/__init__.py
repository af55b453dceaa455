"""``palpate study planning``: simulated operators on the routes of plans, with and without the plan as guidance."""
