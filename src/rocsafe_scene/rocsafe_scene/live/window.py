# SPDX-License-Identifier: Apache-2.0
"""A window that shows pictures, by Tk, which comes with Python."""

from typing import Any

from rocsafe_geo.arrays import ImageArray
from rocsafe_scene.errors import EngineError


class Window:
    """A window with the newest picture, and the keys that were pressed.

    Parameters
    ----------
    title
        Of the window.

    Raises
    ------
    EngineError
        If none can be opened; one line.
    """

    def __init__(self, title: str) -> None:
        # Imported on use: Python need not have Tk where nobody looks.
        try:
            import tkinter
        except ImportError as error:
            raise EngineError('a window needs Tk: install python3-tk') from error
        try:
            self._root: Any = tkinter.Tk()
        except tkinter.TclError as error:
            raise EngineError(f'no window can be opened: {error}') from error
        self._make_image = tkinter.PhotoImage
        self._label: Any = tkinter.Label(self._root, borderwidth=0)
        self._label.pack()
        self._root.title(title)
        self._root.protocol('WM_DELETE_WINDOW', self.close)
        self._root.bind('<Key>', self._on_key)
        self._keys: list[str] = []
        self.is_open = True

    def show(self, image: ImageArray) -> list[str]:
        """Show a picture, blue, green, red; return the keys pressed since the last one."""
        if self.is_open:
            rows, columns, _ = image.shape
            head = f'P6 {columns} {rows} 255\n'.encode()
            picture = self._make_image(data=head + image[..., ::-1].tobytes(), format='PPM')
            self._label.configure(image=picture)
            # Tk keeps no reference of its own.
            self._label.image = picture
            self._root.update()
        keys, self._keys = self._keys, []
        return keys

    def _on_key(self, event: Any) -> None:
        self._keys.append(event.char)

    def close(self) -> None:
        """Close it."""
        self.is_open = False
        self._root.destroy()
