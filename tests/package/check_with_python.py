"""check_with_python.py MAKE_SAMPLE_PACKAGE SCHEMAS

A package seen by tools that share no code with beatlas: Python's zipfile, hashlib, jsonschema.
"""
import copy
import hashlib
import json
import pathlib
import subprocess
import sys
import tempfile
import zipfile

import jsonschema


def validator(schemas: pathlib.Path, name: str) -> jsonschema.Draft202012Validator:
    store = {p.name: json.loads(p.read_text()) for p in schemas.glob("*.schema.json")}
    schema = store[name]
    jsonschema.Draft202012Validator.check_schema(schema)
    resolver = jsonschema.RefResolver(base_uri=name, referrer=schema, store=store)
    return jsonschema.Draft202012Validator(schema, resolver=resolver)


def main() -> None:
    maker, schemas = sys.argv[1], pathlib.Path(sys.argv[2])
    with tempfile.TemporaryDirectory() as folder:
        package = pathlib.Path(folder) / "sample.beatlas"
        info_file = pathlib.Path(folder) / "info.json"
        subprocess.run([maker, str(package), str(info_file)], check=True)
        assert not [p for p in pathlib.Path(folder).iterdir() if p not in (package, info_file)]
        info = json.loads(info_file.read_text())
        with zipfile.ZipFile(package) as archive:
            assert archive.testzip() is None
            entries = archive.infolist()
            assert entries[0].filename == "atlas.json"
            assert all(e.date_time == (1980, 1, 1, 0, 0, 0) for e in entries)
            assert all(e.compress_type == zipfile.ZIP_STORED for e in entries)
            manifest = json.loads(archive.read("atlas.json"))
            named = {item["path"]: item for item in manifest["items"]}
            assert set(named) == {e.filename for e in entries[1:]} and len(named) == 11
            for path, item in named.items():
                payload = archive.read(path)
                assert len(payload) == item["bytes"], path
                assert hashlib.sha256(payload).hexdigest() == item["sha256"], path

    check = validator(schemas, "manifest.schema.json")
    check.validate(manifest)
    validator(schemas, "info.schema.json").validate(info)
    for key in ("format_version", "frame_times_s", "rr_interval_s", "workspace_from_lps",
                "structures", "items", "scene"):
        assert info[key] == manifest[key], key
    lv = next(s for s in info["structures"] if s["name"] == "lv_blood")["volume_ml"]
    expected = 1 - lv[info["end_systole"]] / lv[info["end_diastole"]]
    assert abs(info["ejection_fraction"] - expected) < 1e-12

    # The schema must be able to refuse: every key is required, and none can be added.
    for key in manifest:
        less = {k: v for k, v in manifest.items() if k != key}
        assert not check.is_valid(less), key
    assert not check.is_valid({**manifest, "surprise": 1})
    for part in ("structures", "items"):
        for key in list(manifest[part][0]) + ["surprise"]:
            changed = copy.deepcopy(manifest)
            changed[part][0].pop(key, None) or changed[part][0].update({key: 1})
            assert not check.is_valid(changed), (part, key)


main()
