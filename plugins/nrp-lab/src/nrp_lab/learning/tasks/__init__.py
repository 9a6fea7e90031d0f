"""The tasks, one module each with its body beside it."""

from typing import Final

from nrp_lab.learning.task import Task
from nrp_lab.learning.tasks.ball import Ball
from nrp_lab.learning.tasks.maze import Maze
from nrp_lab.learning.tasks.obstacles import Obstacles
from nrp_lab.learning.tasks.pole import Pole
from nrp_lab.learning.tasks.reach import Reach
from nrp_lab.learning.tasks.wall import Wall

TASKS: Final[dict[str, type[Task]]] = {task.name: task for task in (Maze, Ball, Pole, Wall, Reach, Obstacles)}
"""The tasks by name."""
