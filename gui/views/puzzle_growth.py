"""A picture that grows: pieces go from one layout to another, a few with each frame."""

import numpy as np

from .puzzle_layout import Layout, growing
from .puzzle_sheet import Sheet


class Growth:
    """Pieces go in an `order` (k,) from where `full` has them to where `goal` has them, in a number of frames."""

    def __init__(self, full: Layout, goal: Layout, order: np.ndarray, frames: int) -> None:
        self.full, self.goal, self.order = full, goal, order
        self.done, self.each = 0, max(1, -(-len(order) // frames))

    @property
    def ended(self) -> bool:
        """Whether all pieces are there."""
        return self.done >= len(self.order)

    def step(self, sheet: Sheet) -> Layout:
        """Move the next few pieces on a sheet; the layout that it then shows."""
        following = self.order[self.done : self.done + self.each].tolist()
        for piece in following:
            sheet.clear(piece, self.full)
        for piece in following:
            sheet.paste(piece, self.goal)
        sheet.refresh()
        self.done += len(following)
        shown = np.zeros(len(self.full.placed), bool)
        shown[self.order[: self.done]] = True
        sheet.layout = growing(self.full, self.goal, shown)
        return sheet.layout
