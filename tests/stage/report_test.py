"""The report of a study, read as a user's browser reads it: report_test.py BEATLAS WORK_FOLDER NAME

WORK_FOLDER is that of stage_test.py, whose `study` left a study. Chromium runs without a network and
opens the page as a file.
"""
import base64
import contextlib
import io
import json
import pathlib
import re
import shutil
import time

import jsonschema
import nibabel
import numpy
from PIL import Image
from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

import stage_test
from stage_test import STUDY, WORK, beatlas, new_folder

SCHEMA = pathlib.Path(__file__).parents[2] / "schemas" / "report.schema.json"
MOST_BYTES = 15e6  # what mail and archives take
VIEWS = (1280, 400)  # a desk's and a telephone's width in pixels


@contextlib.contextmanager
def browser(page, width=1280):
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium")
    for word in ("--headless=new", "--no-sandbox", "--enable-unsafe-swiftshader", "--hide-scrollbars",
                 "--disable-dev-shm-usage", f"--window-size={width},900"):
        options.add_argument(word)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    service = webdriver.chrome.service.Service(shutil.which("chromedriver"))
    driver = webdriver.Chrome(service=service, options=options)
    try:
        driver.execute_cdp_cmd("Network.enable", {})
        driver.execute_cdp_cmd("Network.emulateNetworkConditions",
                               {"offline": True, "latency": 0, "downloadThroughput": 0, "uploadThroughput": 0})
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                               {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False})
        driver.get(page.as_uri())
        wait(driver, "return document.body.dataset.ready > 0")
        yield driver
        # The driver's word on reading pixels back, which only the test does, is none of the page's.
        said = [line for line in driver.get_log("browser") if "due to ReadPixels" not in line["message"]]
        assert not said, f"the page says nothing in the console: {said}"
    finally:
        driver.quit()


def wait(driver, script, seconds=20):
    end = time.monotonic() + seconds
    while not driver.execute_script(script):
        assert time.monotonic() < end, f"never came true: {script}"
        time.sleep(0.05)


def pixels(driver, selector):
    """What a canvas shows."""
    text = driver.execute_script("return document.querySelector(arguments[0]).toDataURL('image/png')", selector)
    return numpy.asarray(Image.open(io.BytesIO(base64.b64decode(text.split(",")[1]))).convert("RGB")).astype(int)


def change(a, b):
    """Share of pixels that differ by more than JPEG and smoothing explain."""
    assert a.shape == b.shape, (a.shape, b.shape)
    return (abs(a - b).max(axis=2) > 24).mean()


def move(driver, slider, value):
    driver.execute_script("const s = document.getElementById(arguments[0]); s.value = arguments[1];"
                          "s.dispatchEvent(new Event('input', {bubbles: true}))", slider, str(value))
    time.sleep(0.3)


def choose(driver, select, value):
    driver.execute_script("const s = document.getElementById(arguments[0]); s.value = arguments[1];"
                          "s.dispatchEvent(new Event('change', {bubbles: true}))", select, value)
    time.sleep(0.2)


def summary_of(folder):
    told = json.loads((folder / "report.json").read_text())
    jsonschema.validate(told, json.loads(SCHEMA.read_text()))
    return told


def is_sound(told):
    """Nothing is wrong; the prior, which has learned from hearts with atria, may doubt where an RV without one ends."""
    doubts = [reason for reason in told["reasons"] if reason["id"].startswith("expected_rv_blood")]
    return doubts == told["reasons"] and told["verdict"] == ("check" if doubts else "good")


def parts_beyond_the_heart_ml():
    """[phase]: of all voxels together, by how much what lies in the heart is covered by more than the heart."""
    files = {file.name: nibabel.load(file) for file in (STUDY / "segment").glob("coverage_*.nii.gz")}
    heart = files.pop("coverage_heart.nii.gz")
    parts = sum(numpy.asarray(file.dataobj) for file in files.values())
    voxel_ml = numpy.prod(heart.header.get_zooms()[:3]) / 1000
    return numpy.clip(parts - numpy.asarray(heart.dataobj), 0, None).sum(axis=(0, 1, 2)) * voxel_ml


def figures():
    """What programs read agrees with the package and follows the schema; the page is one file."""
    page = STUDY / "report.html"
    told = summary_of(STUDY)
    info = json.loads(beatlas("info", WORK / "study.beatlas", "--json").stdout)
    assert told["package"]["bytes"] == (WORK / "study.beatlas").stat().st_size
    assert told["package"]["sha256"] == stage_test.digest(WORK / "study.beatlas")
    # Fields are smooth where labels' coverage is not: a percent of a volume (1.2 of the heart's), a point of the EF.
    # The field of the heart holds its parts, too, where they are covered by more than the heart is.
    beyond_ml = parts_beyond_the_heart_ml()
    for structure in info["structures"]:
        assert len(told["volumes_ml"][structure["name"]]) == len(structure["volume_ml"]) == stage_test.PHASES
        for phase, (mine, theirs) in enumerate(zip(told["volumes_ml"][structure["name"]], structure["volume_ml"])):
            held_ml = beyond_ml[phase] if structure["name"] == "heart" else 0
            assert abs(mine + held_ml - theirs) < 0.015 * max(structure["volume_ml"]), structure["name"]
    assert abs(told["figures"]["lv_ef_percent"] - 100 * info["ejection_fraction"]) < 1
    made = json.loads((STUDY / "pack" / "contents.json").read_text())["enclosed_ml"]  # by the package's own surfaces
    for name in ("lv_blood", "rv_blood"):
        largest, smallest = (told["volumes_ml"][name].index(end(told["volumes_ml"][name])) for end in (max, min))
        said = f"{name[:2].upper()} {100 * (1 - made[name][smallest] / made[name][largest]):.1f} % for the labels'"
        assert said in page.read_text() and f" % (phases {largest} and {smallest})" in page.read_text(), said
    intervals = told["intervals_90"]
    assert len(intervals) == 9, intervals
    assert all(low <= told["figures"][key] <= high and low < high for key, (low, high) in intervals.items()), intervals
    known = told["surfaces_90"]
    assert set(known) == {"heart", "lv_blood", "rv_blood", "lv_myocardium"}, known
    for name, surface in known.items():
        assert 0 < surface["in_slices_mm"] <= surface["worst_slice_mm"], surface
        bands = [entry for entry in info["structures"] if entry["name"] == name][0]["band"]
        assert len(bands["across_mm"]) == len(bands["along_mm"]) == stage_test.PHASES
        worst = bands["across_mm"][info["end_diastole"]][surface["worst_slice"]]
        assert abs(worst - surface["worst_slice_mm"]) < 0.06, (worst, surface)
    assert abs(told["rr_interval_s"] - json.loads((WORK / "phantom" / "truth.json").read_text())["rr_interval_s"]) < 2e-3
    assert is_sound(told) and told["before"] is None, told["reasons"]
    assert json.loads(beatlas("report", STUDY, "--json", "-o", WORK / "again.html").stdout) == told
    assert page.stat().st_size < MOST_BYTES
    text = page.read_text()
    assert not re.search(r"(src|href)=\"(?!data:|#)", text.split("<script")[0]), "nothing outside the file"
    assert "{{" not in text.split('id="data"')[0]
    # The browser: what it measures from opening the file to the end of its scripts.
    with browser(page) as driver:
        spent = driver.execute_script("return performance.timing.loadEventEnd - performance.timing.navigationStart")
        ready = driver.execute_script("return document.body.dataset.ready")
        print(f"{page.stat().st_size} bytes, loaded in {spent} ms, all drawn after {ready} ms")
        assert driver.find_element(By.CSS_SELECTOR, "#verdict h1").text == told["verdict"].capitalize()
        shown = driver.find_element(By.CSS_SELECTOR, "#verdict dd").text
        assert shown == f"{told['figures']['lv_ef_percent']:.0f} %", shown
        shown = [entry.text for entry in driver.find_elements(By.CSS_SELECTOR, "#verdict dd.interval")]
        low, high = (int(end + 0.5) for end in intervals["lv_ef_percent"])
        assert len(shown) == 9 == len(intervals) and shown[0] == f"{low} to {high}", shown
        titles = driver.execute_script("return [...document.querySelectorAll('h2')].filter(h => h.offsetParent).map(h => h.textContent)")
        assert {"The beat", "Outlines and surface", "What was checked, and why", "The package", "Provenance"} <= set(titles), titles


def pictures():
    """Sliders and keys change what is shown; outlines lie on the image, the surface is drawn and cut."""
    told = summary_of(STUDY)
    image, heart = "#slice-view canvas", "#heart-view canvas"
    with browser(STUDY / "report.html") as driver:
        time.sleep(0.5)
        for canvas in (image, heart):
            assert pixels(driver, canvas).std() > 10, f"{canvas} shows something"
        at_ed = [pixels(driver, canvas) for canvas in (image, heart)]
        move(driver, "slider-phase-of-the-beat", told["end_systole"])
        at_es = [pixels(driver, canvas) for canvas in (image, heart)]
        assert all(change(a, b) > 0.01 for a, b in zip(at_ed, at_es)), "the heart beats"
        assert f"phase {told['end_systole']}" in driver.find_element(By.CSS_SELECTOR, "#slice-view .caption").text
        driver.find_element(By.CSS_SELECTOR, image).send_keys(Keys.ARROW_UP)
        time.sleep(0.3)
        other = pixels(driver, image)
        assert change(at_es[0], other) > 0.005, "another slice is shown"

        # Without outlines the image is grey; with them it has their colours.
        def coloured(shown):
            return ((shown.max(axis=2) - shown.min(axis=2)) > 60).sum()
        with_lines = coloured(other)
        boxes = driver.find_elements(By.CSS_SELECTOR, "#legend input")
        assert len(boxes) == 4
        with_surface = pixels(driver, heart)
        for box in boxes:
            box.click()
        time.sleep(0.3)
        assert with_lines > 500 and coloured(pixels(driver, image)) == 0
        without = pixels(driver, heart)
        ground = numpy.array([0x14, 0x18, 0x1e])
        assert (abs(without - ground).max(axis=2) < 3).mean() > 0.98, "nothing but the ground and marks"
        assert change(with_surface, without) > 0.1, "the surface was drawn"
        for box in boxes:
            box.click()
        time.sleep(0.2)
        assert change(pixels(driver, heart), with_surface) < 1e-3

        # Turned, cut open, cut elsewhere: each time another picture. Blood, which the heart's muscle
        # covers from outside, shows in the cut.
        def blood(shown):
            return ((shown[..., 0] > 170) & (shown[..., 1] < 130) & (shown[..., 2] < 130)).mean()
        driver.find_element(By.CSS_SELECTOR, heart).send_keys(Keys.ARROW_LEFT)
        time.sleep(0.2)
        turned = pixels(driver, heart)
        assert change(with_surface, turned) > 0.01
        choose(driver, "cut-way", "long")
        cut = pixels(driver, heart)
        assert change(turned, cut) > 0.01
        assert blood(cut) > 0.01 + blood(turned), (blood(cut), blood(turned))
        move(driver, "slider-cut-at", 25)
        assert change(cut, pixels(driver, heart)) > 0.01


def layout():
    """Nothing overlaps or runs out of the page at either width; every control has a name; on paper too."""
    for width in VIEWS:
        with browser(STUDY / "report.html", width) as driver:
            wait(driver, "return document.body.dataset.strip === 'drawn'")
            assert driver.execute_script("return document.documentElement.scrollWidth") <= width
            wrong = driver.execute_script("""
              const out = [];
              const blocks = [...document.querySelectorAll('#verdict > *, main > section, .two > *, .figures > div')].filter(e => e.offsetParent);
              for (const a of blocks) for (const b of blocks) {
                if (a === b || a.contains(b) || b.contains(a)) continue;
                const r = a.getBoundingClientRect(), s = b.getBoundingClientRect();
                if (r.left < s.right - 1 && s.left < r.right - 1 && r.top < s.bottom - 1 && s.top < r.bottom - 1) out.push([a.id || a.className, b.id || b.className]);
              }
              for (const e of document.querySelectorAll('.figures dd, button, h1, h2')) if (e.offsetParent && e.scrollWidth > e.clientWidth + 2 && e.clientWidth) out.push(e.textContent);
              return out;""")
            assert not wrong, wrong
            nameless = driver.execute_script("""
              return [...document.querySelectorAll('button, input, select, canvas[role=img], svg[role=img]')].filter(e =>
                !(e.getAttribute('aria-label') || e.textContent.trim() || (e.labels && e.labels.length))).map(e => e.outerHTML.slice(0, 90));""")
            assert not nameless, nameless
            if width == VIEWS[0]:
                # On paper no slider moves: all slices at end-diastole and end-systole.
                wait(driver, "return document.body.dataset.paper === 'drawn'")
                slices = driver.execute_script("return JSON.parse(document.getElementById('data').textContent).slices.list.length")
                sheets = driver.execute_script("""
                  return [...document.querySelectorAll('#paper .strip')].map(s => [...s.querySelectorAll('canvas')].map(c => {
                    const p = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
                    return [p.some((v, i) => i % 4 < 3 && v > 60), c.toDataURL()]; }));""")
                assert slices > 0 and [len(sheet) for sheet in sheets] == [slices, slices], [len(sheet) for sheet in sheets]
                assert all(drawn for sheet in sheets for drawn, _ in sheet)
                middle = slices // 2
                assert sheets[0][middle][1] != sheets[1][middle][1], "two moments"
                assert not driver.find_element(By.ID, "paper").is_displayed()
                # Tables keep their columns on A4, which is as narrow as a telephone on its side, and none is cut.
                metrics = {"width": 720, "height": 1040, "deviceScaleFactor": 1, "mobile": False}
                driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
                driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
                stacked, cut = driver.execute_script("""
                  for (const e of document.querySelectorAll('details')) e.open = true;
                  const tables = [...document.querySelectorAll('table')].filter(t => t.offsetParent);
                  return [tables.filter(t => getComputedStyle(t.tHead).display === 'none').length,
                          tables.filter(t => t.scrollWidth > t.parentElement.clientWidth + 1).map(t => t.textContent.slice(0, 60))];""")
                assert stacked == 0 and not cut, (stacked, cut)
                driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
                paper = base64.b64decode(driver.execute_cdp_cmd("Page.printToPDF", {"printBackground": True})["data"])
                assert paper[:5] == b"%PDF-" and len(paper) > 100_000, "a page with its pictures"
                assert len(re.findall(rb"/Type\s*/Page\b", paper)) >= 2


def correction():
    """A leak is shown with the command that corrects it; afterwards stands what was before."""
    import nibabel
    folder, package = new_folder("report_study"), WORK / "report.beatlas"
    shutil.copytree(STUDY, folder)
    good = summary_of(folder)
    file = folder / "segment" / "labels.nii.gz"
    whole = file.read_bytes()
    labels = nibabel.load(file)
    painted = numpy.asarray(labels.dataobj).copy()
    inside = numpy.argwhere(painted[..., 2] > 0)
    low, middle = inside.min(axis=0), inside.mean(axis=0).astype(int)
    painted[:low[0] + 8, middle[1] - 8:middle[1] + 8, middle[2] - 4:middle[2] + 4, 2] = 4
    nibabel.save(nibabel.Nifti1Image(painted, labels.affine, labels.header), file)
    # As it stands, without a build: the report says that the package is not of these labels.
    told = json.loads(beatlas("report", folder, "--json").stdout)
    jsonschema.validate(told, json.loads(SCHEMA.read_text()))
    assert told["verdict"] == "check", told["reasons"]
    assert {"leaks", "up_to_date"} <= {reason["id"] for reason in told["reasons"]}, told["reasons"]
    places = [place for place in told["places"] if place["kind"] == "leak"]
    assert places and all(place["commands"] == ["beatlas build --study ."] for place in places), "painted labels are kept"
    assert told["before"]["verdict"] == good["verdict"] and told["before"]["figures"] == good["figures"]
    with browser(folder / "report.html") as driver:
        assert driver.find_element(By.CSS_SELECTOR, "#verdict h1").text == "Check"
        cards = driver.find_elements(By.CSS_SELECTOR, ".place.leak")
        assert len(cards) == len(places)
        assert len(driver.find_elements(By.CSS_SELECTOR, ".place .count")) == len(told["places"])
        assert all(words in cards[0].text for words in (places[0]["sentence"], *places[0]["commands"]))
        driver.execute_script("arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})", cards[0])
        cards[0].find_element(By.CSS_SELECTOR, "button").click()
        time.sleep(0.5)
        caption = driver.find_element(By.CSS_SELECTOR, "#slice-view .caption").text
        assert f"phase {places[0]['phase']}" in caption, caption
        shown = pixels(driver, "#slice-view canvas")
        ring = (shown[..., 0] > 200) & (shown[..., 1] < 140) & (shown[..., 2] > 180)
        assert ring.sum() > 100, "the place is ringed"
        marks = pixels(driver, "#heart-view canvas")
        assert ((marks[..., 0] > 130) & (marks[..., 1] < 70) & (marks[..., 2] > 110)).sum() > 50, "and marked on the surface"
        assert "Before and after" in driver.find_element(By.ID, "compared").text
    # Corrected: as it was, and what was wrong stands beside it.
    file.write_bytes(whole)
    beatlas("build", "--study", folder, "-o", package)
    told = summary_of(folder)
    assert is_sound(told) and told["figures"] == good["figures"], told["reasons"]
    assert told["before"]["verdict"] == "check" and told["before"]["volumes_ml"] != told["volumes_ml"]

    # Refused by the recipe: no package, and a report that says so.
    strict = WORK / "report_strict.json"
    strict.write_text(json.dumps({"quality": {"max_volume_gap_percent": 0.1}, "mesh": {"edge_mm": 8}}))
    said = beatlas("build", "--study", folder, "-o", package, "--recipe", strict, code=4).stderr
    told = summary_of(folder)
    assert told["verdict"] == "rejected" and told["package"] is None, told["reasons"]
    assert "max_volume_gap_percent" in told["reasons"][0]["sentence"] and "max_volume_gap_percent" in said
    pack = json.loads(beatlas("status", folder, "--json").stdout)["stages"][-1]
    assert pack["state"] == "refused" and "max_volume_gap_percent" in pack["refused"], pack
    # Where the report cannot be written, the refusal is still what ends the build.
    (folder / "report.html").unlink()
    (folder / "report.html").mkdir()
    said = beatlas("build", "--study", folder, "-o", package, "--recipe", strict, code=4).stderr
    assert "warning: the report was not written: " in said, said
    assert "max_volume_gap_percent" in said.splitlines()[-1], said
    (folder / "report.html").rmdir()
    (folder / "report.html").touch()
    # Left out when it is not wanted.
    (folder / "report.html").unlink()
    (folder / "report.json").unlink()
    beatlas("build", "--study", folder, "-o", package, "--recipe", strict, "--no-report", code=4)
    assert not (folder / "report.html").exists() and not (folder / "report.json").exists()


def marking():
    """A click into the image gives the command that marks the voxel there, and the command is taken."""
    folder = new_folder("report_marks")
    shutil.copytree(STUDY, folder)
    told = summary_of(folder)
    data = data_of(folder / "report.html")
    page = (folder / "report.html").read_text()
    assert data["drawn_phases"] == [] and '"drawn_phases":[]' in page
    with browser(folder / "report.html") as driver:
        assert not driver.find_element(By.CSS_SELECTOR, ".seed").is_displayed()
        canvas = driver.find_element(By.CSS_SELECTOR, "#slice-view canvas")
        driver.execute_script("arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})", canvas)
        webdriver.ActionChains(driver).move_to_element_with_offset(canvas, 11, -7).click().perform()
        time.sleep(0.2)
        choose(driver, "seed-label", "rv_blood")
        command = driver.find_element(By.CSS_SELECTOR, ".seed code").text
        shown = driver.execute_script("const r = arguments[0].getBoundingClientRect(); return [r.width, r.height]", canvas)
        # Labels that were given for a phase stay, so that a click gives a command in the others alone.
        given = folder / "given.html"
        given.write_text(page.replace('"drawn_phases":[]', f'"drawn_phases":[{told["end_diastole"]}]'))
        driver.get(given.as_uri())
        wait(driver, "return document.body.dataset.ready > 0")
        for phase in (told["end_diastole"], told["end_systole"]):
            move(driver, "slider-phase-of-the-beat", phase)
            canvas = driver.find_element(By.CSS_SELECTOR, "#slice-view canvas")
            driver.execute_script("arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})", canvas)
            webdriver.ActionChains(driver).move_to_element_with_offset(canvas, 11, -7).click().perform()
            time.sleep(0.2)
            commands = [code.text for code in driver.find_elements(By.CSS_SELECTOR, ".seed code")]
            if phase == told["end_diastole"]:
                assert not commands and "stay as they are" in driver.find_element(By.CSS_SELECTOR, ".seed").text
            else:
                assert [line.endswith(f"--phase {phase}") for line in commands] == [True], commands
    # The middle of the canvas is the middle of the part that is shown, in square millimetres.
    spacing, size, first = data["slices"]["spacing_mm"], data["slices"]["size"], data["slices"]["first"]
    fit = min(shown[axis] / (size[axis] * spacing[axis]) for axis in (0, 1))
    column, row = (int(first[axis] + size[axis] / 2 + move / (fit * spacing[axis])) for axis, move in ((0, 11), (1, -7)))
    middle = len(data["slices"]["list"]) // 2
    assert command == (f"beatlas seeds . add --label rv_blood --slice {middle} --row {row} --column {column} "
                       f"--phase {told['end_diastole']}"), command
    words = command.split()
    words[2] = str(folder)
    said = beatlas(*words[1:]).stdout
    assert f"(slice, row, column {middle}, {row}, {column})" in said, said


def of_package():
    """Of a package alone: its volumes, checks and pictures, no leaks and nothing to run."""
    study = summary_of(STUDY)
    lone = new_folder("report_package")
    lone.mkdir()
    shutil.copyfile(WORK / "study.beatlas", lone / "a.beatlas")
    told = json.loads(beatlas("report", lone / "a.beatlas", "-o", lone / "page.html", "--json").stdout)
    jsonschema.validate(told, json.loads(SCHEMA.read_text()))
    assert sorted(file.name for file in lone.iterdir()) == ["a.beatlas", "page.html"]
    info = json.loads(beatlas("info", lone / "a.beatlas", "--json").stdout)
    for structure in info["structures"]:
        volumes = told["volumes_ml"][structure["name"]]
        assert numpy.allclose(volumes, structure["volume_ml"], atol=0.006), structure["name"]
    assert told["verdict"] == "good" and not told["reasons"], told["reasons"]
    assert told["places"] == [] and told["slice_shifts_mm"] == [] and told["before"] is None
    assert told["intervals_90"] == told["surfaces_90"] == {}
    assert told["package"] == study["package"] and told["input_sha256"] == study["input_sha256"]
    # Outlines lie where the study's do: half a voxel beside them at most where they enclose as much.
    mine, theirs = data_of(lone / "page.html"), data_of(STUDY / "report.html")
    assert {finding["id"] for finding in mine["findings"]}.isdisjoint({"leaks", "slice_shifts", "ef_agrees"})
    assert mine["slices"]["structures"] == theirs["slices"]["structures"]
    for name in mine["slices"]["structures"]:
        ours, made = (numpy.array([area(data, name, k) for k in range(len(data["slices"]["list"]))])
                      for data in (mine, theirs))
        worst = abs(ours - made).max() / made.max()
        print(f"{name}: areas of outlines differ by {100 * worst:.1f} % of the largest at most")
        assert made.max() > 300 and numpy.median(abs(ours - made)) < 0.05 * made.max(), (name, ours, made)
    with browser(lone / "page.html") as driver:
        assert driver.find_element(By.CSS_SELECTOR, "#verdict h1").text == "Good"
        assert "package alone" in driver.find_element(By.ID, "verdict").text
        image, heart = (pixels(driver, f"#{name}-view canvas") for name in ("slice", "heart"))
        assert image.std() > 10 and ((image.max(axis=2) - image.min(axis=2)) > 60).sum() > 500, "outlines on the image"
        assert heart.std() > 10
        text = driver.find_element(By.TAG_NAME, "body").text
        assert "beatlas seeds" not in text and "Worth a look" not in text and not driver.find_elements(By.CSS_SELECTOR, ".seed")
    # Without images or without distances the page says so and shows what there is.
    shutil.copytree(STUDY, lone / "study")
    for scene, says, slices in (("palpation", "holds no images", True), ("anatomy", "nothing of which slices", False)):
        other = lone / f"{scene}.beatlas"
        beatlas("pack", "--study", lone / "study", "-o", other, "--scene", scene)
        told = json.loads(beatlas("report", other, "-o", lone / "page.html", "--json").stdout)
        assert told["verdict"] == "good", told["reasons"]
        with browser(lone / "page.html") as driver:
            assert says in driver.find_element(By.ID, "views").text
            shown = driver.find_elements(By.CSS_SELECTOR, "#slice-view canvas")
            assert bool(shown) == slices and pixels(driver, "#heart-view canvas").std() > 10


def area(data, name, k):
    """What the outlines of a structure enclose in a slice at end-diastole [mm2]."""
    slices, phase = data["slices"], data["summary"]["end_diastole"]
    words = iter(numpy.frombuffer(base64.b64decode(slices["list"][k]["outlines"]), "<i2").tolist())
    for p in range(phase + 1):
        for structure in slices["structures"]:
            total = 0
            for _ in range(next(words)):
                points = numpy.array([(next(words), next(words)) for _ in range(next(words) & 0xffff)], float) / 32
                x, y = points.T
                total += (x * numpy.roll(y, -1) - y * numpy.roll(x, -1)).sum() / 2
            if p == phase and structure == name:
                return abs(total) * slices["spacing_mm"][0] * slices["spacing_mm"][1]
    raise KeyError(name)


def data_of(page):
    """What the page draws."""
    text = page.read_text().split('<script id="data" type="application/json">')[1].split("</script>")[0]
    return json.loads(text)


def one_verdict():
    """What `validate` finds wrong with the package is in what build says, in the report and its reasons;
    what later stages said stays in the study and is shown."""
    import nibabel
    from study_test import EXAM, RECIPE, write_recipe
    folder, package = new_folder("one_verdict"), WORK / "one_verdict.beatlas"
    said = beatlas("build", EXAM, "-o", package, "--study", folder, "--recipe", RECIPE).stderr
    told = summary_of(folder)
    assert json.loads(beatlas("validate", package, "--json").stdout)["failures"] == []
    assert "checks" not in {reason["id"] for reason in told["reasons"]}, told["reasons"]
    low, high = (int(end + 0.5) for end in told["intervals_90"]["lv_edv_ml"])
    figures_told = f"beatlas: LV: EDV {int(told['figures']['lv_edv_ml'] + 0.5)} ml (90 %: {low} to {high}), ESV "
    assert figures_told in said.split("beatlas: verdict: ")[0], said
    assert f"beatlas: verdict: {told['verdict']}" in said and str(folder / "report.html") in said, said
    checks = next(finding for finding in data_of(folder / "report.html")["findings"] if finding["id"] == "checks")
    assert checks["level"] == "good" and checks["said"].startswith("all of "), checks

    # An island of RV blood beside the heart, in one phase, and told to keep it: stray.
    file = folder / "segment" / "labels.nii.gz"
    labels = nibabel.load(file)
    painted = numpy.asarray(labels.dataobj).copy()
    low = numpy.argwhere(painted[..., 2] > 0).min(axis=0)
    assert (low[:2] > 14).all(), low
    middle = painted.shape[2] // 2
    painted[low[0] - 13:low[0] - 3, low[1] - 13:low[1] - 3, middle - 2:middle + 3, 2] = 1
    nibabel.save(nibabel.Nifti1Image(painted, labels.affine, labels.header), file)
    keeping = WORK / "one_verdict_keeping.json"
    write_recipe(keeping, field={"handles": "keep"})
    said = beatlas("build", "--study", folder, "-o", package, "--recipe", keeping).stderr
    failures = json.loads(beatlas("validate", package, "--json", code=4).stdout)["failures"]
    assert any(line.startswith("rv_blood: islands beside it") for line in failures), failures
    told = summary_of(folder)
    reason = next(reason["sentence"] for reason in told["reasons"] if reason["id"] == "checks")
    assert told["verdict"] == "check" and all(line in reason for line in failures), (reason, failures)
    assert all(f"warning: pack: {line}" in said for line in failures) and "beatlas: verdict: check; " in said, said
    # Warnings of the stages: in the study, and on the page after a build that kept them.
    mesh = [line.split("warning: mesh: ")[1] for line in said.splitlines() if "warning: mesh: " in line]
    assert mesh == json.loads((folder / "study.json").read_text())["stages"]["mesh"]["warnings"]
    assert any(line.startswith("the mesh of rv_blood") and "in phase 2: its labels" in line for line in mesh), mesh
    beatlas("build", "--study", folder, "-o", package)
    beatlas("report", folder)
    remarks = next(finding for finding in data_of(folder / "report.html")["findings"] if finding["id"] == "remarks")
    assert all(f"mesh: {line}" in remarks["said"] for line in mesh), remarks


if __name__ == "__main__":
    import sys
    globals()[sys.argv[3]]()
