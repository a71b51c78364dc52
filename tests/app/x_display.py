"""A virtual display with a user at it: keys go in by XTEST, the screen comes out as pixels. For tests; needs Xvfb and libXtst."""

import ctypes
import ctypes.util
import os
import shutil
import subprocess
import time


def missing():
    """The reason why there can be none, or None."""
    if not shutil.which("Xvfb"):
        return "no Xvfb"
    for library in ("X11", "Xtst"):
        if not ctypes.util.find_library(library):
            return "no lib%s" % library
    return None


class XImage(ctypes.Structure):
    _fields_ = [("width", ctypes.c_int), ("height", ctypes.c_int), ("xoffset", ctypes.c_int), ("format", ctypes.c_int),
                ("data", ctypes.c_void_p), ("byte_order", ctypes.c_int), ("bitmap_unit", ctypes.c_int),
                ("bitmap_bit_order", ctypes.c_int), ("bitmap_pad", ctypes.c_int), ("depth", ctypes.c_int),
                ("bytes_per_line", ctypes.c_int), ("bits_per_pixel", ctypes.c_int)]


class Display:
    def __init__(self, width, height):
        self.size = width, height
        out, into = os.pipe()
        self.server = subprocess.Popen(["Xvfb", "-displayfd", str(into), "-screen", "0", "%dx%dx24" % self.size, "-nolisten", "tcp"],
                                       pass_fds=[into], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(into)
        with os.fdopen(out) as number:
            self.name = ":" + number.readline().strip()
        self.x, self.test = (ctypes.CDLL(ctypes.util.find_library(name)) for name in ("X11", "Xtst"))
        for call in ("XOpenDisplay", "XGetImage"):
            getattr(self.x, call).restype = ctypes.c_void_p
        for call in ("XDefaultRootWindow", "XStringToKeysym"):
            getattr(self.x, call).restype = ctypes.c_ulong
        self.display = ctypes.c_void_p(self.x.XOpenDisplay(self.name.encode()))
        self.root = ctypes.c_ulong(self.x.XDefaultRootWindow(self.display))

    def environment(self):
        return {**os.environ, "DISPLAY": self.name}

    def close(self):
        self.x.XCloseDisplay(self.display)
        self.server.terminate()
        self.server.wait()

    def focus(self):
        """Gives the keyboard to the one window on the screen. There is no window manager that would."""
        root, parent, children, count = ctypes.c_ulong(), ctypes.c_ulong(), ctypes.POINTER(ctypes.c_ulong)(), ctypes.c_uint()
        self.x.XQueryTree(self.display, self.root, ctypes.byref(root), ctypes.byref(parent), ctypes.byref(children),
                          ctypes.byref(count))
        if count.value:
            self.x.XSetInputFocus(self.display, ctypes.c_ulong(children[count.value - 1]), 1, 0)
            self.x.XSync(self.display, 0)

    def press(self, *names):
        self.focus()
        for name in names:
            code = self.x.XKeysymToKeycode(self.display, ctypes.c_ulong(self.x.XStringToKeysym(name.encode())))
            for down in (1, 0):
                self.test.XTestFakeKeyEvent(self.display, code, down, 0)
        self.x.XSync(self.display, 0)

    def drag(self, start, end):
        """With the left button, from one pixel to another."""
        self.test.XTestFakeMotionEvent(self.display, -1, *start, 0)
        self.test.XTestFakeButtonEvent(self.display, 1, 1, 0)
        for k in range(1, 9):
            at = (a + (b - a) * k // 8 for a, b in zip(start, end))
            self.test.XTestFakeMotionEvent(self.display, -1, *at, 20)
        self.test.XTestFakeButtonEvent(self.display, 1, 0, 20)
        self.x.XSync(self.display, 0)

    def screen(self):
        """Bytes blue, green, red, 0 of each pixel, row by row."""
        width, height = self.size
        image = self.x.XGetImage(self.display, self.root, 0, 0, width, height, ctypes.c_ulong(0xFFFFFFFF), 2)
        fields = XImage.from_address(image)
        pixels = ctypes.string_at(fields.data, fields.bytes_per_line * height)
        self.x.XDestroyImage(ctypes.c_void_p(image))
        return pixels

    def wait_until(self, is_so, seconds=60):
        """The first screen that is so, and does not change for a while; None where none comes."""
        end, before = time.monotonic() + seconds, None
        while time.monotonic() < end:
            now = self.screen()
            if now == before and is_so(now):
                return now
            before = now
            time.sleep(0.4)
        return None
