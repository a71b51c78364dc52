#!/usr/bin/env python3
"""cuda_arch_test.py SOURCE: which compute capabilities a build for CUDA chooses, and what it prints before it compiles.
nvidia-smi, nvcc and CMake's configure step are stand-ins: neither a GPU nor CUDA is needed."""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

SOURCE = Path(sys.argv[1]).resolve()
ARCHS = {"12.4": "50 52 60 61 62 70 72 75 80 86 87 89 90", "12.8": "50 60 61 70 75 80 86 89 90 100 101 120",
         "13.0": "75 80 86 87 88 89 90 100 110 103 120 121"}
GTX = "6.1, NVIDIA GeForce GTX 1080 Ti"
ADA = "8.9, NVIDIA GeForce RTX 4090"
BLACKWELL = "12.0, NVIDIA GeForce RTX 5090"

# (CUDA, GPUs, DRENCH_CUDA_ARCH, archs or None for an error, what the lines contain)
CASES = [
    ("12.4", [ADA], "", [89], ["building for compute capability 8.9 (NVIDIA GeForce RTX 4090) with CUDA 12.4"]),
    ("12.4", [GTX], "", [61], ["6.1 (NVIDIA GeForce GTX 1080 Ti)"]),
    ("12.8", [BLACKWELL], "", [120], ["12.0 (NVIDIA GeForce RTX 5090)"]),
    ("13.0", ["7.0, Tesla V100"], "", None, ["Tesla V100 has compute capability 7.0", "install CUDA 12"]),
    ("13.0", ["7.5, T4"], "", [75], ["7.5 (T4)"]),
    ("13.0", ["9.0, NVIDIA H200", "9.0, NVIDIA H200"], "", [90], ["9.0 (NVIDIA H200)"]),
    # code runs on later capabilities of the same generation
    ("13.0", ["10.3, NVIDIA B300"], "", [100], ["10.0 (NVIDIA B300)"]),
    ("13.0", ["12.1, NVIDIA GB10"], "", [120], ["12.0 (NVIDIA GB10)"]),
    ("12.4", ["8.7, Orin"], "", [86], ["8.6 (Orin)"]),
    # too new a card: the driver translates; too old a one: an error
    ("12.4", [BLACKWELL], "", [90], ["driver translates", "install CUDA 12.8 or newer"]),
    ("13.0", [GTX], "", None, ["GTX 1080 Ti has compute capability 6.1", "install CUDA 12 and set CUDA_ROOT"]),
    ("12.4", ["5.2, GTX 980"], "", None, ["5.2, drench needs 6.1 or newer"]),
    # several kinds of GPU
    ("12.4", [ADA, GTX], "", [61, 89], ["8.9 (NVIDIA GeForce RTX 4090)", "6.1 (NVIDIA GeForce GTX 1080 Ti)"]),
    ("13.0", [GTX, ADA], "", [89], ["building for compute capability 8.9", "GTX 1080 Ti has compute capability 6.1"]),
    # no GPU
    ("12.4", [], "", None, ["nvidia-smi lists no GPU", "set DRENCH_CUDA_ARCH"]),
    ("12.4", None, "", None, ["nvidia-smi lists no GPU"]),
    ("12.4", None, "89", [89], ["8.9 with CUDA 12.4"]),
    # named
    ("12.4", None, "all", [61, 70, 75, 80, 86, 89, 90], ["6.1, 7.0, 7.5, 8.0, 8.6, 8.9, 9.0 with CUDA 12.4"]),
    ("12.8", None, "all", [61, 70, 75, 80, 86, 89, 90, 100, 120], ["10.0, 12.0"]),
    ("13.0", None, "all", [75, 80, 86, 89, 90, 100, 120], ["7.5, 8.0"]),
    ("12.4", None, "90,61", [61, 90], ["6.1, 9.0"]),
    ("12.4", [GTX], "90", [90], ["will not run on this machine's NVIDIA GeForce GTX 1080 Ti (6.1)", "unset DRENCH_CUDA_ARCH"]),
    ("12.4", [BLACKWELL], "90", [90], ["9.0 with CUDA 12.4"]),
    ("13.0", None, "61", None, ["CUDA 13.0 does not compile for 6.1", "install CUDA 12 "]),
    ("12.4", None, "120", None, ["CUDA 12.4 does not compile for 12.0", "CUDA 12.8 or newer"]),
    ("12.4", None, "8.9", None, ["DRENCH_CUDA_ARCH is '8.9', allowed: 61, 70,"]),
    ("12.4", None, "60", None, ["allowed: 61, 70,"]),
]
KOKKOS = {61: "PASCAL61", 70: "VOLTA70", 75: "TURING75", 80: "AMPERE80", 86: "AMPERE86", 89: "ADA89", 90: "HOPPER90",
          100: "BLACKWELL100", 120: "BLACKWELL120"}


def program(path, text):
    path.write_text(text)
    path.chmod(0o755)


def fakes(folder, cuda, gpus):
    """A PATH with these GPUs, and a CUDA_ROOT."""
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "bin").mkdir(parents=True)
    archs = "\n".join(f"compute_{a}" for a in ARCHS[cuda].split())
    program(folder / "bin/nvcc", f"""#!/bin/sh
case $1 in
  --list-gpu-arch) echo '{archs}' ;;
  --version) echo 'Cuda compilation tools, release {cuda}, V{cuda}.1' ;;
  *) exit 1 ;;
esac
""")
    (folder / "path").mkdir()
    listing = "exit 9" if gpus is None else "echo 'No devices were found'" if not gpus else "\n".join(f"echo '{g}'" for g in gpus)
    program(folder / "path/nvidia-smi", f"#!/bin/sh\n[ \"$1\" = --query-gpu=compute_cap,name ] || exit 2\n{listing}\n")
    return {**os.environ, "PATH": f"{folder / 'path'}:{os.environ['PATH']}", "CUDA_ROOT": str(folder)}


def flags(archs):
    words = [f"-gencode=arch=compute_{a},code=sm_{a}" for a in archs[1:-1]]
    if len(archs) > 1:
        words.append(f"-gencode=arch=compute_{archs[-1]},code=[sm_{archs[-1]},compute_{archs[-1]}]")
    return " ".join(words)


def choose(scratch):
    """The choice alone."""
    for cuda, gpus, named, archs, contained in CASES:
        case = f"CUDA {cuda}, {gpus}, DRENCH_CUDA_ARCH '{named}'"
        ran = subprocess.run(["cmake", "--log-level=VERBOSE", "-D", f"DRENCH_CUDA_ARCH={named}", "-P",
                              SOURCE / "tools/cmake/cuda_arch.cmake"], env=fakes(scratch / "fakes", cuda, gpus),
                             capture_output=True, text=True)
        assert ran.returncode == 0, (case, ran.stderr)
        for text in contained:
            assert text in ran.stderr, f"{case}: '{text}' is not in '{ran.stderr}'"
        if archs is None:
            assert ran.stderr.startswith("error: ") and ran.stderr.count("\n") == 1, (case, ran.stderr)
        else:
            assert "error" not in ran.stderr, (case, ran.stderr)
            wanted = f"-- Kokkos {KOKKOS[archs[0]]}, nvcc {flags(archs)}".rstrip()
            assert ran.stdout.strip() == wanted, f"{case}: '{ran.stdout.strip()}', wanted '{wanted}'"


def build(scratch):
    """tools/build, which stops before CMake configures, or hands the choice on."""
    tree = scratch / "tree"
    shutil.copytree(SOURCE / "tools/cmake", tree / "tools/cmake")
    shutil.copytree(SOURCE / "tools/presets", tree / "tools/presets")
    shutil.copy(SOURCE / "tools/build", tree / "tools/build")
    program(tree / "tools/setup", "#!/bin/sh\n")

    def run(cuda, gpus, **variables):
        environment = fakes(scratch / "fakes", cuda, gpus)
        environment.pop("DRENCH_CUDA_ARCH", None)
        environment.pop("FETCHCONTENT_SOURCE_DIR_KOKKOS", None)
        environment.pop("DRENCH_WERROR", None)
        program(scratch / "fakes/path/cmake",
                f"#!/bin/sh\ncase \"$*\" in *' -P '*) exec {shutil.which('cmake')} \"$@\" ;; esac\necho \"$*\" >>{scratch}/cmake.log\n")
        (scratch / "cmake.log").write_text("")
        ran = subprocess.run([tree / "tools/build", "cuda", "float", "drench"], env={**environment, **variables},
                             capture_output=True, text=True)
        return ran.returncode, ran.stderr, (scratch / "cmake.log").read_text()

    code, errors, log = run("13.0", [GTX])
    assert code == 1 and log == "", (code, log)
    assert errors.startswith("tools/build: the NVIDIA GeForce GTX 1080 Ti has") and errors.count("\n") == 1, errors
    code, errors, log = run("12.4", [GTX])
    assert code == 0 and errors.startswith("CUDA: building for compute capability 6.1"), (code, errors)
    assert "-DDRENCH_CUDA_ARCH=\n" in log and "--build" in log, log
    code, errors, log = run("12.4", None, DRENCH_CUDA_ARCH="all")
    assert code == 0 and "-DDRENCH_CUDA_ARCH=all" in log, (code, errors, log)


with tempfile.TemporaryDirectory() as folder:
    choose(Path(folder))
    build(Path(folder))
print(f"{len(CASES)} choices and tools/build: passed")
