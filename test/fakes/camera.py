# SPDX-License-Identifier: Apache-2.0
"""Cameras on the loopback interface that stream JPEG frames: by RTSP (RFC 2326, 2435) and by HTTP.

Each frame is of one grey that tells when it was taken, so that a test sees which one it was given.
"""

import contextlib
import re
import socket
import struct
import threading
import time

import cv2
import numpy as np

WIDTH, HEIGHT = 160, 120
RATE_HZ = 10.0
# Greys are told apart after a JPEG coder; they come round after three seconds.
STEP, GREYS = 8, 30
CLOCK_HZ = 90_000
JPEG_PAYLOAD = 26
# What a chroma of half size in both directions is to RFC 2435, and tables that come along.
TYPE_420, OWN_TABLES = 1, 255
FRAGMENT = 1000
BOUNDARY = b'frame'


def grey_frame(number):
    """Return frame `number` as a JPEG file."""
    pixels = np.full((HEIGHT, WIDTH, 3), STEP * (number % GREYS) + 8, np.uint8)
    return cv2.imencode('.jpg', pixels)[1].tobytes()


def number_of(jpeg):
    """Return the number of a frame, of the last `GREYS`."""
    pixels = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_GRAYSCALE)
    return round((float(pixels.mean()) - 8.0) / STEP) % GREYS


class Camera:
    """Serves whoever calls, until it is closed.

    Attributes
    ----------
    port : where it listens.
    callers : how many have called.
    is_frozen : whether it keeps its line open and sends nothing.
    """

    scheme = ''

    def __init__(self, port=0):
        self.callers = 0
        self.is_frozen = False
        self._is_over = threading.Event()
        self._server = socket.create_server(('127.0.0.1', port))
        self._server.settimeout(0.1)
        self.port = self._server.getsockname()[1]
        self._threads = [threading.Thread(target=self._serve, daemon=True)]
        self._threads[0].start()

    @property
    def address(self):
        """What a viewer opens."""
        return f'{self.scheme}://127.0.0.1:{self.port}/live'

    @staticmethod
    def number_at(unix_s):
        """Return the number of the frame that is taken at a time."""
        return int(unix_s * RATE_HZ)

    def close(self):
        """End all."""
        self._is_over.set()
        for thread in self._threads:
            thread.join(timeout=5.0)
        self._server.close()

    def _serve(self):
        while not self._is_over.is_set():
            try:
                line, _ = self._server.accept()
            except TimeoutError:
                continue
            self.callers += 1
            line.settimeout(0.05)
            thread = threading.Thread(target=self._attend, args=(line,), daemon=True)
            self._threads.append(thread)
            thread.start()

    def _attend(self, line):
        try:
            with line:
                self._talk(line)
        except (OSError, StopIteration):
            # The viewer has gone, or the camera is switched off.
            return

    def _frames(self):
        """Yield (number, JPEG file) of each new frame, None while there is none."""
        last = -1
        while not self._is_over.is_set():
            number = self.number_at(time.time())
            is_new = number != last and not self.is_frozen
            last = number
            yield (number, grey_frame(number)) if is_new else None


class HttpCamera(Camera):
    """Motion JPEG as multipart/x-mixed-replace."""

    scheme = 'http'

    def _talk(self, line):
        line.recv(4096)
        kind = b'multipart/x-mixed-replace; boundary=' + BOUNDARY
        line.sendall(b'HTTP/1.0 200 OK\r\nContent-Type: ' + kind + b'\r\n\r\n')
        for frame in self._frames():
            if frame is None:
                time.sleep(0.01)
                continue
            _, jpeg = frame
            head = f'Content-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n\r\n'.encode()
            line.sendall(b'--' + BOUNDARY + b'\r\n' + head + jpeg + b'\r\n')


class RtspCamera(Camera):
    """RTP/JPEG within the RTSP connection, as viewers ask for it behind firewalls."""

    scheme = 'rtsp'

    def _talk(self, line):
        is_playing, sequence, rest = False, 0, b''
        for frame in self._frames():
            with contextlib.suppress(TimeoutError):
                rest += self._received(line)
            while b'\r\n\r\n' in rest:
                request, _, rest = rest.partition(b'\r\n\r\n')
                is_playing = self._answer(line, request.decode()) or is_playing
            if frame is not None and is_playing:
                sequence = self._send(line, frame, sequence)

    def _received(self, line):
        data = line.recv(4096)
        if not data:
            raise StopIteration
        return data

    def _answer(self, line, request):
        """Answer a request; return whether it was to play."""
        # Reports of the receiver come in between; nobody reads them.
        found = re.search(r'(OPTIONS|DESCRIBE|SETUP|PLAY|TEARDOWN|GET_PARAMETER) ', request)
        if found is None:
            return False
        method = found[1]
        number = re.search(r'CSeq: *(\d+)', request)[1]
        lines, body = [f'CSeq: {number}', 'Session: 1'], ''
        if method == 'OPTIONS':
            lines.append('Public: OPTIONS, DESCRIBE, SETUP, PLAY, TEARDOWN, GET_PARAMETER')
        elif method == 'DESCRIBE':
            body = (
                'v=0\r\no=- 0 0 IN IP4 127.0.0.1\r\ns=camera\r\nt=0 0\r\n'
                f'm=video 0 RTP/AVP {JPEG_PAYLOAD}\r\na=control:track0\r\n'
            )
            lines += ['Content-Type: application/sdp', f'Content-Length: {len(body)}']
        elif method == 'SETUP' and 'interleaved' not in request:
            line.sendall(f'RTSP/1.0 461 Unsupported Transport\r\nCSeq: {number}\r\n\r\n'.encode())
            return False
        elif method == 'SETUP':
            lines.append('Transport: RTP/AVP/TCP;unicast;interleaved=0-1')
        line.sendall(('\r\n'.join(['RTSP/1.0 200 OK', *lines, '', '']) + body).encode())
        if method == 'TEARDOWN':
            raise StopIteration
        return method == 'PLAY'

    def _send(self, line, frame, sequence):
        number, jpeg = frame
        tables, scan = parts_of(jpeg)
        stamp = round(number / RATE_HZ * CLOCK_HZ) % 2**32
        for start in range(0, len(scan), FRAGMENT):
            piece = scan[start : start + FRAGMENT]
            marker = 0x80 if start + FRAGMENT >= len(scan) else 0
            head = struct.pack('>BBHII', 0x80, marker | JPEG_PAYLOAD, sequence % 2**16, stamp, 1)
            head += struct.pack('>I', start)
            head += bytes((TYPE_420, OWN_TABLES, WIDTH // 8, HEIGHT // 8))
            if start == 0:
                head += struct.pack('>BBH', 0, 0, len(tables)) + tables
            packet = head + piece
            line.sendall(struct.pack('>BBH', ord('$'), 0, len(packet)) + packet)
            sequence += 1
        return sequence


def parts_of(jpeg):
    """Return the quantisation tables and the coded pixels of a JPEG file."""
    tables, at = b'', 2
    while True:
        marker, size = jpeg[at + 1], int.from_bytes(jpeg[at + 2 : at + 4], 'big')
        body = jpeg[at + 4 : at + 2 + size]
        if marker == 0xDB:
            tables += b''.join(body[n + 1 : n + 65] for n in range(0, len(body), 65))
        at += 2 + size
        if marker == 0xDA:
            return tables, jpeg[at:].removesuffix(b'\xff\xd9')
