"""Another machine that is reached by ssh: its program drench, its folders and its messages. Does not need Blender.

All connections use the program ssh of this system, so that its configuration, agent and keys apply. The other machine
needs a POSIX shell, tar and awk. ssh never asks for a password, because nobody could answer."""

import os
import re
import shlex
import subprocess
import tarfile
import tempfile
from dataclasses import dataclass
from pathlib import Path

from .problem import Problem
from .program import HIDDEN

SECONDS_TO_CONNECT = 10
SECONDS_OF_SILENCE = 15  # then the connection counts as lost
MARK = b"drench begins\n"  # what the other machine prints before it, for example a greeting, is skipped
HOST = re.compile(r"[\w.@:%\[\]][\w.@:%\[\]-]*")
NAME = re.compile(r"\w[\w-]*", re.ASCII)

BEGIN = """
echo 'drench begins'
cd || exit
export LC_ALL=C
case $program in /*) ;; */*) program=$HOME/$program ;; esac
alive() {
  pid=$(cat pid 2>/dev/null) && kill -0 "$pid" 2>/dev/null &&
    { [ ! -d /proc/self ] || [ "/proc/$pid/cwd" -ef . ]; }
}
"""

UPLOAD = 'mkdir -p "$folder" && cd "$folder" && rm -f stop && tar -xof - || exit\n'

INFO = '"$program" info\n'

CHECK = """
trap 'cd && rm -rf "$folder"' EXIT
""" + UPLOAD + """
"$program" check scene.yaml
"""

# A file `stop` ends a run that starts at the same time.
STOP = """
cd "$folder" 2>/dev/null || exit 0
: >stop
if alive; then
  kill -TERM "$pid"
  while alive && [ $grace -gt 0 ]; do sleep 1; grace=$((grace - 1)); done
  alive && kill -KILL "$pid"
  while alive; do sleep 1; done
fi
rm -f run/.*.part run/frames/.*.part
"""

REMOVE = STOP + 'cd && rm -rf "$folder"\n'

# Starts the run, or continues it from its checkpoint, unless it still runs or is complete. It outlives the connection.
START = """
[ -n "$uploaded" ] || { cd "$folder" && [ -e pid ]; } 2>/dev/null || { echo upload; exit 0; }
if [ -n "$start" ] && ! alive && [ "$(cat exit 2>/dev/null)" != 0 ]; then
  [ -n "$uploaded" ] || rm -f stop
  rm -f pid exit run/.*.part run/frames/.*.part
  set -- -o run --overwrite
  for file in run/checkpoint_*.drench; do [ -e "$file" ] && set -- --resume run; done
  nohup sh -c 'sh -c "echo \\$\\$ >pid && exec \\"\\$0\\" \\"\\$@\\"" "$0" "$@" >>drench.log 2>&1; echo $? >exit' \\
    "$program" run scene.yaml "$@" $threads </dev/null >/dev/null 2>&1 &
  for second in 1 2 3 4 5; do [ -s pid ] || [ -e exit ] || sleep 1; done
  [ ! -e stop ] || { alive && kill -TERM "$pid"; }
fi
echo started
"""

# Sends each frame that the lists contain, and then its list up to this frame; at the end the other files of the run. A
# run that is stopped adds a frame of its last step, which a later run replaces: `every` tells it from regular frames.
FOLLOW = """
next_entry() {
  awk -F '"' -v n=$next -v every="$every" '
    /<DataSet / && ++k == n { time = $2; frame = number = $6 }
    !/<DataSet / || k <= n { print }
    END {
      sub(/.*_/, "", number)
      off = time / every - number
      exit k < n || off * off > 1e-8 && frame !~ /_static/
    }' "$list" 2>/dev/null
}
send() {
  size=$(wc -c <"$1") || return
  printf 'file %d %s\\n' "$size" "$1"
  head -c "$size" "$1"
}
while :; do
  over= more=
  alive || over=1
  for list in run/*.pvd; do
    series=${list##*/} series=${series%.pvd}
    eval "next=\\$((have_$series + 1))"
    text=$(next_entry) || continue
    frame=${text##*file=\\"} frame=${frame%%\\"*}
    [ "$frame" = "$static" ] || send "run/$frame" || continue
    case $frame in *_static.vtu) static=$frame ;; esac
    printf 'file %d %s\\n%s\\n' $((${#text} + 1)) "$list" "$text"
    eval "have_$series=$next"
    more=1
  done
  [ -z "$more" ] || continue
  if [ -n "$over" ]; then
    [ -s exit ] || sleep 1
    rm -f run/.*.part run/frames/.*.part
    for file in drench.log run/*; do
      case $file in *.drench | *.pvd) ;; *) [ -f "$file" ] && send "$file" ;; esac
    done
    echo "exit $(cat exit 2>/dev/null)"
    exit 0
  fi
  size=$(wc -c <drench.log)
  [ "$size" = "$logged" ] || { logged=$size; send drench.log; }
  echo wait
  sleep 0.5 2>/dev/null || sleep 1
done
"""

# What ssh or the other machine prints, and what the user reads. {ssh} is the command to try in a terminal.
REASONS = (
    ("Could not resolve hostname|Name or service not known",
     "the host {host} is unknown: correct it in the preferences of the extension"),
    ("Host key verification failed|IDENTIFICATION HAS CHANGED",
     "the host key of {host} is not known on this computer, or it has changed: run '{ssh}' once in a terminal"),
    (r"Permission denied \(|Too many authentication failures",
     "{host} refused the key: '{ssh}' must work in a terminal without a password"),
    ("No space left on device|[Dd]isk quota exceeded", "the disk of {host} is full: free some space there"),
    ("libcuda|libamdhip|no CUDA device|compute capability",
     "drench on {host} was built for a GPU that {host} does not have ({line}): enter another program in the "
     "preferences"),
    ("Connection refused|timed out|No route to host|unreachable|Connection (?:closed|reset)|not responding",
     "{host} cannot be reached ({line}): check the machine, the network and the port"))


@dataclass(frozen=True)
class Machine:
    host: str  # user@host, or a name of ssh's configuration
    port: int = 0
    identity: str = ""
    program: str = "drench"
    folder: str = "drench_bakes"  # relative to the home folder

    def __post_init__(self):
        if not self.host:
            raise Problem("there is no remote machine: enter its host in the preferences of the extension")
        if not HOST.fullmatch(self.host):
            raise Problem(f"'{self.host}' is not a host: enter it as user@host, or as a name of ssh's configuration")
        if self.identity and not Path(self.identity).is_file():
            raise Problem(f"the identity file {self.identity} does not exist: correct it in the preferences")

    def _ssh(self):
        port = ["-p", str(self.port)] if self.port else []
        return ["ssh", *port, *(["-i", self.identity] if self.identity else []), self.host]

    def _words(self, script, name, **values):
        values = {"program": _from_home(self.program or "drench"), "folder": f"{_from_home(self.folder) or '.'}/{name}",
                  **values}
        text = "".join(f"{key}={shlex.quote(str(value))}\n" for key, value in values.items()) + BEGIN + script
        ssh, *more = self._ssh()
        options = {"BatchMode": "yes", "ConnectTimeout": SECONDS_TO_CONNECT, "LogLevel": "ERROR",
                   "ServerAliveInterval": SECONDS_OF_SILENCE // 3, "ServerAliveCountMax": 3,
                   **({"IdentitiesOnly": "yes"} if self.identity else {})}
        return [ssh, "-T", *(f"-o{key}={value}" for key, value in options.items()), *more, "sh -c " + shlex.quote(text)]

    def open(self, script, name="", source=subprocess.DEVNULL, errors=subprocess.PIPE, **values):
        """Starts a script in a home folder there. `source`: a file that it reads. Returns the process."""
        try:
            return subprocess.Popen(self._words(script, name, **values), stdin=source, stdout=subprocess.PIPE,
                                    stderr=errors, start_new_session=os.name == "posix", **HIDDEN)
        except OSError as error:
            raise Problem(f"the program ssh cannot be started: {error.strerror}: install OpenSSH") from None

    def call(self, script, name="", seconds=120, **more):
        """Runs a short script. Returns (exit code, what it printed, its errors)."""
        process = self.open(script, name, **more)
        try:
            out, err = process.communicate(timeout=seconds)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            raise Problem(f"{self.host} did not answer within {seconds} s: try it again") from None
        _, mark, out = out.partition(MARK)
        errors = err.decode("utf-8", "replace")
        if process.returncode == 255 or not mark:
            raise self.problem(errors)
        return process.returncode, out.decode("utf-8", "replace"), errors

    def problem(self, errors):
        """The Problem behind the error messages of a connection or a script."""
        lines = [line.strip() for line in errors.splitlines() if line.strip()] or ["the connection ended"]
        for pattern, text in REASONS:
            if found := [line for line in lines if re.search(pattern, line)]:
                return Problem(text.format(host=self.host, ssh=shlex.join(self._ssh()),
                                           line=re.sub(r"^(drench|ssh): ", "", found[0])))
        return Problem(f"{self.host}: {lines[-1]}")

    def info(self, version):
        """One line about the program there, which must have this version."""
        code, out, errors = self.call(INFO)
        found = dict(re.findall(r"^(\w+): (.*)$", out, re.M))
        if "version" not in found:
            if code in (126, 127) and not re.search("shared librar", errors):
                raise Problem(f"drench was not found on {self.host}, where its path is '{self.program}': correct it in "
                              "the preferences of the extension")
            raise self.problem(errors or f"'{self.program}' is not the program drench")
        if found["version"] != version:
            raise Problem(f"drench on {self.host} has version {found['version']}, this extension needs {version}: "
                          "install the same version on both")
        parts = [found.get("backend", ""), found.get("device", ""), f"{found.get('threads', '?')} threads"]
        return f"drench {version} on {self.host}: " + ", ".join(filter(None, parts))

    def check(self, folder, name):
        """Checks the scene in a folder of this computer there. Returns (exit code, lines)."""
        with packed(folder) as source:
            code, out, errors = self.call(CHECK, name, seconds=600, source=source)
        if code and "No space left" in errors:
            raise self.problem(errors)
        return code, (errors + "\n" + out).splitlines()

    def stop(self, name, seconds):
        self.call(STOP, name, seconds=seconds + 60, grace=seconds)

    def remove(self, name):
        self.call(REMOVE, name, grace=5)


def _from_home(path):
    """Scripts start in the home folder, and a quoted ~ has no meaning."""
    return re.sub(r"^~/", "./", path).rstrip("/") or path


def packed(folder, wanted=True):
    """An open temporary file with the scene and the meshes of a folder, as tar; empty if they are not wanted."""
    file = tempfile.TemporaryFile(dir=folder)
    if wanted:
        with tarfile.open(fileobj=file, mode="w") as archive:
            for name in ("scene.yaml", "meshes"):
                archive.add(Path(folder) / name, name)
        file.seek(0)
    return file
