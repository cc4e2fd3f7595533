#!/usr/bin/python3 -IS
"""A Python that has numpy, h5py and matplotlib loaded: for TALUS_PYTHON, by which `talus plot` finds its Python.

    with serve(folder, root) as path:  # for runs with TALUS_PYTHON=path and TALUS_WARM_PYTHON=folder

Run as a program, it hands its words, folder, environment and open files to the server. That runs the script in a fork:
a third of the time of a picture.
"""
import array
import contextlib
import json
import os
import socket
import sys

NAME = "TALUS_WARM_PYTHON"


def ask(words):
    """The client: the exit status of what the server has run."""
    with socket.socket(socket.AF_UNIX) as line:
        line.connect(os.path.join(os.environ[NAME], "socket"))
        files = array.array("i", [0, 1, 2])
        line.sendmsg([b"x"], [(socket.SOL_SOCKET, socket.SCM_RIGHTS, files)])
        line.sendall(json.dumps([words, os.getcwd(), dict(os.environ)]).encode() + b"\n")
        return int(line.makefile().readline() or 1)


def answer(line, root):
    """In a forked process of the server: runs what is asked for, with the client's files."""
    from launcher import become

    _, (rights,), _, _ = line.recvmsg(1, socket.CMSG_SPACE(3 * 4))
    words, folder, environment = json.loads(line.makefile().readline())
    for number, file in enumerate(array.array("i", rights[2])):
        os.dup2(file, number)
    sys.stdout, sys.stderr = (open(k, "w", encoding="utf-8", errors="backslashreplace", closefd=False) for k in (1, 2))
    status = become(words[0], words[1:], folder, environment, root)
    sys.stdout.flush()
    sys.stderr.flush()
    line.sendall(f"{status}\n".encode())


def listen(place, root):
    """The server: a forked process for each client, one after the other."""
    import h5py  # noqa: F401
    import matplotlib.pyplot  # noqa: F401

    while True:
        line, _ = place.accept()
        process = os.fork()
        if not process:
            try:
                answer(line, root)
            finally:
                os._exit(0)
        line.close()
        os.waitpid(process, 0)


@contextlib.contextmanager
def serve(folder, root):
    """A server with its socket in a folder, for the while; the path of its Python."""
    with socket.socket(socket.AF_UNIX) as place:
        place.bind(os.path.join(folder, "socket"))
        place.listen()
        process = os.fork()
        if not process:
            try:
                listen(place, root)
            finally:
                os._exit(1)
        try:
            yield os.path.realpath(__file__)
        finally:
            os.kill(process, 15)
            os.waitpid(process, 0)


if __name__ == "__main__":
    if sys.argv[1] == "-c":  # is asked for modules: the Python behind it has them
        os.execv("/usr/bin/python3", ["/usr/bin/python3", *sys.argv[1:]])
    sys.exit(ask(sys.argv[1:]))
