"""The script library of the report, built from its npm package: `python tools/vendor.py` (needs node and npm).

three.js is bundled to what the page uses, as one classic script, with its licence at its head. Beside it stands where
it is from, its version and its checksum, which a test holds.
"""

from __future__ import annotations

import hashlib
import json
import subprocess
import tempfile
from pathlib import Path

FOLDER = Path(__file__).parents[1] / "src/toolpace/results/report/vendor"
THREE, ESBUILD = "0.187.0", "0.28.2"
USED = (
    *("Box3", "BoxGeometry", "BufferAttribute", "BufferGeometry", "Color", "CylinderGeometry", "DirectionalLight"),
    *("Group", "HemisphereLight", "LineBasicMaterial", "LineSegments", "Matrix4", "Mesh", "MeshLambertMaterial"),
    *("PerspectiveCamera", "Scene", "Vector3", "WebGLRenderer"),
)
LINES = ("LineMaterial", "LineSegments2", "LineSegmentsGeometry")
"""Lines broader than a pixel."""


def main() -> None:
    """Fetch, bundle, write."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "package.json").write_text('{"private": true}')
        packages = [f"three@{THREE}", f"esbuild@{ESBUILD}"]
        subprocess.run(["npm", "install", "--no-audit", "--no-fund", *packages], cwd=folder, check=True)
        entry = [f'export {{ {", ".join(USED)} }} from "three";']
        entry += [f'export {{ {name} }} from "three/addons/lines/{name}.js";' for name in LINES]
        (folder / "entry.js").write_text("\n".join(entry))
        how = ("--bundle", "--minify", "--format=iife", "--global-name=THREE", "--legal-comments=none")
        command = ["npx", "esbuild", "entry.js", *how]
        done = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True)
        licence = (folder / "node_modules/three/LICENSE").read_text(encoding="utf-8").strip()
    # an end tag in a string would end the script of the page
    assert "</script" not in done.stdout
    text = f"/*\nthree.js {THREE}, https://threejs.org\n\n{licence}\n*/\n{done.stdout}"
    FOLDER.mkdir(exist_ok=True)
    (FOLDER / "three.min.js").write_text(text, encoding="utf-8")
    about = {
        "three.min.js": {
            "package": "three", "version": THREE, "licence": "MIT", "bundled_by": f"esbuild {ESBUILD}",
            "sha256": hashlib.sha256(text.encode()).hexdigest(),
        }
    }  # fmt: skip
    (FOLDER / "vendored.json").write_text(json.dumps(about, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
