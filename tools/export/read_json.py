"""Reads a .json file of another program: a scene of SPlisHSPlasH or a material of ARCSim. `drench import FILE` starts it."""

import sys
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent))

import read_arcsim
import read_splishsplash
from json_lines import read_json
from scene_files import run_reader


def importer(source, folder):
    reader = read_arcsim if read_arcsim.is_material(read_json(source)) else read_splishsplash
    return reader.Importer(source, folder)


if __name__ == "__main__":
    run_reader("read_json.py", __doc__, importer)
