"""What a power cut can leave of a folder: the system calls of a process, read from the output of strace, and the disks after them.

The rules are those of POSIX, and of a file system with a journal for names:

| What | Survives a power cut |
|---|---|
| data of a file before its last `fsync` or `fdatasync` | always |
| data after it | each sector of 512 octets or not, in any order; a sector that is lost has its old content, or zeros behind the old end |
| the length of a file after it | the old one or a later one, also when the data behind the old end are lost |
| names (create, rename, link, unlink) before the last `fsync` of the folder | always |
| names after it | the first ones, up to any of them |

A file that is mapped for writing is not followed: SQLite maps only the index of its log, which it makes anew.
"""

import os
import re

SECTOR = 512
CALLS = ("open,openat,creat,close,read,write,pwrite64,writev,pwritev,pwritev2,lseek,truncate,ftruncate,fallocate,copy_file_range,sendfile,"
         "rename,renameat,renameat2,link,linkat,unlink,unlinkat,fsync,fdatasync,sync_file_range,dup,dup2,dup3,fcntl")
# Calls that change a file in a way that is not followed. A trace with one of them is refused.
UNKNOWN = {"pwritev", "pwritev2", "truncate", "fallocate", "copy_file_range", "sendfile"}

LINE = re.compile(r"^(\d+) +(\d+\.\d+) (.*)$")
RESUMED = re.compile(r"^<\.\.\. \w+ resumed>(.*)$")
CALL = re.compile(r"^(\w+)\((.*)\) += (-?\d+)(?:<.*>)?(?: .*)?$", re.S)
STRING = re.compile(r'"((?:\\x[0-9a-f]{2})*)"(\.\.\.)?')


def command(output):
    """The command that traces another one into a file: all octets, with the path of each file and the time of each call."""
    return ["strace", "--follow-forks", "-xx", "--string-limit=33554432", "--decode-fds=path", "-ttt", "--signal=none", "--quiet=all",
            f"--trace={CALLS}", "--output", output]


def octets(text):
    """The octets of a string that strace printed."""
    return bytes.fromhex(text.replace("\\x", ""))


class Call:
    """A finished system call: its name, its arguments, its result, and the times of its beginning and end in seconds."""

    def __init__(self, begun, ended, name, arguments, result):
        self.begun, self.ended, self.name, self.arguments, self.result = begun, ended, name, arguments, result

    def paths(self):
        """The strings among the arguments."""
        return [octets(text).decode() for text, _ in STRING.findall(self.arguments)]

    def data(self):
        """The octets that were written."""
        found = STRING.search(self.arguments)
        if found is None or found[2]:
            raise ValueError(f"strace cut the octets of {self.name}")
        return octets(found[1])[: self.result]

    def file(self):
        """Number and path of the file descriptor that is the first argument."""
        found = re.match(r"(\d+)<((?:\\x[0-9a-f]{2})*)>", self.arguments)
        return (int(found[1]), octets(found[2]).decode()) if found else (None, "")


def calls(trace):
    """The finished calls of a trace in the order of their ends."""
    waiting = {}
    with open(trace) as lines:
        for line in lines:
            found = LINE.match(line.rstrip("\n"))
            if not found:
                continue
            process, time, text = int(found[1]), float(found[2]), found[3]
            if text.endswith("<unfinished ...>"):
                waiting[process] = (time, text[: -len("<unfinished ...>")])
                continue
            begun, resumed = time, RESUMED.match(text)
            if resumed:
                if process not in waiting:
                    continue
                begun, first = waiting.pop(process)
                text = first.rstrip() + resumed[1].lstrip()
            call = CALL.match(text)
            if call and int(call[3]) >= 0:
                yield Call(begun, time, call[1], call[2], int(call[3]))


class Inode:
    """A file without its names: what is safe, and the changes after it as (time, offset, octets) or (time, length, None)."""

    def __init__(self, safe=b""):
        self.safe, self.changes = safe, []

    def length(self):
        """The length that a program sees."""
        length = len(self.safe)
        for _, offset, data in self.changes:
            length = offset if data is None else max(length, offset + len(data))
        return length

    def synchronise(self, begun):
        """Changes before this time are safe."""
        while self.changes and self.changes[0][0] <= begun:
            self.safe = apply(self.safe, [self.changes.pop(0)[1:]])

    def after_a_cut(self, choice):
        """The content with those changes that `choice` keeps."""
        return apply(self.safe, choice([change[1:] for change in self.changes], len(self.safe)))


def apply(content, changes):
    """The content after changes."""
    content = bytearray(content)
    for offset, data in changes:
        if data is None:
            content = content[:offset].ljust(offset, b"\0")
        else:
            content = content.ljust(offset, b"\0")
            content[offset : offset + len(data)] = data
    return bytes(content)


class Disk:
    """A folder during a trace: names and files as the program sees them, and what of them is safe."""

    def __init__(self, folder):
        self.folder = os.path.realpath(folder)
        self.names, self.safe_names, self.name_changes = {}, {}, []
        self.offsets = {}
        for name in os.listdir(self.folder):
            with open(os.path.join(self.folder, name), "rb") as file:
                self.safe_names[name] = Inode(file.read())
        self.names = dict(self.safe_names)

    def name(self, path):
        """The name of a path in this folder; None outside."""
        folder, name = os.path.split(os.path.realpath(path) if not os.path.isabs(path) else path)
        return name if folder == self.folder else None

    def rename_all(self, time, changes):
        """Changes names: pairs of a name and its file; None deletes the name."""
        self.name_changes.append((time, changes))
        change_names(self.names, changes)

    def follow(self, call):
        """Executes a call. Returns whether the disk after a power cut can differ by it."""
        handler = getattr(self, "do_" + HANDLERS.get(call.name, call.name), None)
        if handler:
            return bool(handler(call))
        if call.name in UNKNOWN and self.name(call.file()[1]):
            raise ValueError(f"{call.name} on a file of the folder is not followed")
        return False

    def do_open(self, call):
        name = self.name(call.paths()[0]) if call.paths() else None
        self.offsets[call.result] = 0
        if name is None:
            return False
        is_new = name not in self.names and "O_CREAT" in call.arguments
        if is_new:
            self.rename_all(call.ended, [(name, Inode())])
        file = self.names.get(name)
        if file and "O_TRUNC" in call.arguments and file.length():
            file.changes.append((call.ended, 0, None))
            return True
        if "O_APPEND" in call.arguments:
            self.offsets[call.result] = None
        return is_new

    def do_write(self, call):
        descriptor, path = call.file()
        file = self.names.get(self.name(path))
        if file is None:
            return False
        offset = self.offsets.get(descriptor, 0)
        if offset is None:
            offset = file.length()
        else:
            self.offsets[descriptor] = offset + call.result
        file.changes.append((call.ended, offset, call.data()))
        return True

    def do_writev(self, call):
        descriptor, path = call.file()
        if self.name(path) is None:
            return False
        raise ValueError("writev on a file of the folder is not followed")

    def do_read(self, call):
        descriptor, path = call.file()
        if self.name(path) and self.offsets.get(descriptor) is not None:
            self.offsets[descriptor] += call.result
        return False

    def do_pwrite64(self, call):
        file = self.names.get(self.name(call.file()[1]))
        if file is None:
            return False
        file.changes.append((call.ended, int(call.arguments.rsplit(", ", 1)[1]), call.data()))
        return True

    def do_lseek(self, call):
        self.offsets[call.file()[0]] = call.result
        return False

    def do_ftruncate(self, call):
        file = self.names.get(self.name(call.file()[1]))
        if file is None:
            return False
        file.changes.append((call.ended, int(call.arguments.rsplit(", ", 1)[1]), None))
        return True

    def do_rename(self, call):
        old, new = (self.name(path) for path in call.paths()[-2:])
        if old not in self.names:
            return False
        self.rename_all(call.ended, [(old, None), (new, self.names[old])] if new else [(old, None)])
        return True

    def do_link(self, call):
        old, new = (self.name(path) for path in call.paths()[-2:])
        if old not in self.names or new is None:
            return False
        self.rename_all(call.ended, [(new, self.names[old])])
        return True

    def do_unlink(self, call):
        name = self.name(call.paths()[-1])
        if name not in self.names:
            return False
        self.rename_all(call.ended, [(name, None)])
        return True

    def do_fsync(self, call):
        path = call.file()[1]
        if path == self.folder:
            while self.name_changes and self.name_changes[0][0] <= call.begun:
                change_names(self.safe_names, self.name_changes.pop(0)[1])
            return True
        file = self.names.get(self.name(path))
        if file is None:
            return False
        file.synchronise(call.begun)
        return True

    def cut(self, names, data):
        """The folder after a power cut: `names` of the changes of names are kept, and those changes of data that `data` keeps."""
        kept = dict(self.safe_names)
        for _, changes in self.name_changes[:names]:
            change_names(kept, changes)
        return {name: file.after_a_cut(data) for name, file in kept.items()}


HANDLERS = {"openat": "open", "creat": "open", "fdatasync": "fsync", "renameat": "rename", "renameat2": "rename", "linkat": "link", "unlinkat": "unlink"}


def change_names(names, changes):
    """Changes names: pairs of a name and its file; None deletes the name."""
    for name, file in changes:
        if file is None:
            names.pop(name, None)
        else:
            names[name] = file


def sectors(offset, data):
    """A change, divided at the borders of sectors."""
    while data:
        size = SECTOR - offset % SECTOR
        yield offset, data[:size]
        offset, data = offset + size, data[size:]


def everything(changes, _length):
    """Keeps all changes."""
    return changes


def nothing(_changes, _length):
    """Keeps no change."""
    return []


def only_the_last(changes, _length):
    """Keeps only the last change, so it overtook all others."""
    return changes[-1:]


def all_but_the_last(changes, _length):
    """Loses only the last change."""
    return changes[:-1]


def lengths_only(changes, length):
    """Keeps the length that a file of this length gets, and none of the data."""
    for offset, data in changes:
        length = offset if data is None else max(length, offset + len(data))
    return [(length, None)] if changes else []


def torn(changes, _length):
    """Keeps all but the second half of the last change."""
    if not changes or changes[-1][1] is None:
        return changes
    offset, data = changes[-1]
    return [*changes[:-1], (offset, data[: len(data) // 2])]


def some_sectors(random):
    """Keeps each sector with a probability of one half."""

    def choice(changes, _length):
        kept = []
        for offset, data in changes:
            pieces = [(offset, None)] if data is None else sectors(offset, data)
            kept += [piece for piece in pieces if random.random() < 0.5]
        return kept

    return choice


def cuts(disk, random, repetitions):
    """The folders that a power cut at this moment can leave: with the usual orders, and with random ones."""
    names = len(disk.name_changes)
    for kept_names in {0, names}:
        for data in (everything, nothing, only_the_last, all_but_the_last, lengths_only, torn):
            yield f"{kept_names} of {names} names, {data.__name__}", disk.cut(kept_names, data)
    for _ in range(repetitions):
        kept_names = random.randint(0, names)
        yield f"{kept_names} of {names} names, some sectors", disk.cut(kept_names, some_sectors(random))
