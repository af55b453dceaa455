"""Tasks: what has to be done in a scene, done by a person or by a simulated operator, and scored as in the field."""

from palpate.session.tasks.judge import Judge, Seen, TaskResult
from palpate.session.tasks.run import TaskRun, drawn, judge_in, look

__all__ = ["Judge", "Seen", "TaskResult", "TaskRun", "drawn", "judge_in", "look"]
