"""Tries the artifacts of scripts/package, each in a root directory of its own, and compares their tables. Used by `scripts/package --check`."""
import json, os, re, shutil, subprocess, sys, tarfile, time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "target" / "package"

# Studies that are computed with each program, and options that keep them short. The first has an answer: the probability of a load.
TRIED = [("ci-night.toml", ["--limit", "128"]), ("first-look.toml", []), ("blade-off-risk.toml", ["--limit", "16"]), ("sensitivity.toml", ["--limit", "88"])]


def step(text):
    print(f"== {text}", flush=True)


def tables(run, out):
    """The bytes of the tables of TRIED. `run` runs the program with these words, `out` reads a file that it wrote."""
    found = {}
    for study, options in TRIED:
        run("run", study, *options, "--out", study.removesuffix(".toml"))
        found[study] = out(f"{study.removesuffix('.toml')}/results.parquet")
    return found


def first_answer(artifact, begun, said):
    """Prints the seconds since the beginning and the first answer of what the program printed."""
    found = re.search(r"^ *(P\(.*\) = .*)$", said, re.M)
    if not found:
        sys.exit(f"{artifact}: no answer in\n{said}")
    print(f"{artifact}: first answer after {time.monotonic() - begun:.1f} s: {found[1]}", flush=True)


def compare(artifact, found, expected):
    different = [study for study in expected if found[study] != expected[study]]
    if different:
        sys.exit(f"{artifact}: the table of {', '.join(different)} differs from that of cargo build --release")
    print(f"{artifact}: the tables of {len(expected)} studies are those of cargo build --release, byte for byte", flush=True)


class Root:
    """A root directory with the files that every container has."""

    def __init__(self, place):
        self.place = place
        for name in ("dev/shm", "proc", "etc"):
            (place / name).mkdir(parents=True, exist_ok=True)
        for name, minor in (("null", 3), ("urandom", 9)):
            if not (place / "dev" / name).exists():
                os.mknod(place / "dev" / name, 0o20666, os.makedev(1, minor))

    def run(self, *words, cwd="/"):
        """What a program in this root prints."""
        script = 'mount -t proc proc "$0/proc" && mount -t tmpfs -o size=64m tmpfs "$0/dev/shm" && exec "$@"'
        # chroot(2) by Python: the program chroot cannot change the directory
        enter = "import os, sys; os.chroot(sys.argv[1]); os.chdir(sys.argv[2]); os.execv(sys.argv[3], sys.argv[3:])"
        words = [sys.executable, "-c", enter, self.place, cwd, *words]
        ran = subprocess.run(["unshare", "--mount", "--pid", "--fork", "sh", "-c", script, self.place, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={"PATH": os.environ["PATH"], "LANG": "C.UTF-8"})
        if ran.returncode != 0:
            sys.exit(f"{' '.join(map(str, words[5:]))} in {self.place}: exit code {ran.returncode}\n{ran.stdout}{ran.stderr}")
        return ran.stdout

    def read(self, name):
        return (self.place / name.lstrip("/")).read_bytes()


def debian(folder):
    """A Debian with Python made by debootstrap; None where there is none, which is printed."""
    if not shutil.which("debootstrap") and shutil.which("apt-get"):
        subprocess.run("apt-get update -qq; apt-get install -y -qq debootstrap", shell=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    if not shutil.which("debootstrap"):
        print("SKIPPED: wheel and Dockerfile are not tried in a Debian: debootstrap is not installed", file=sys.stderr)
        return None
    step("a Debian by debootstrap")
    place, begun = folder / "debian", time.monotonic()
    made = subprocess.run(["debootstrap", "--variant=minbase", "--include=python3-venv", "bookworm", place], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if made.returncode != 0:
        print(f"SKIPPED: wheel and Dockerfile are not tried in a Debian: debootstrap failed: {made.stdout.strip().splitlines()[-1]}", file=sys.stderr)
        return None
    print(f"made in {time.monotonic() - begun:.0f} s")
    return place


def try_program(artifact, root, begun, program, studies, cwd, expected):
    """Runs the studies with a program in a root; the first one since `begun`."""
    def run(word, study, *options):
        said = root.run(*program, word, f"{studies}/{study}", *options, cwd=cwd)
        if study == TRIED[0][0]:
            first_answer(artifact, begun, said)
    compare(artifact, tables(run, lambda name: root.read(f"{cwd}/{name}")), expected)


def unpack(tar, place):
    with tarfile.open(tar) as packed:
        packed.extractall(place, filter="fully_trusted")


def try_tar(tar, folder, expected):
    begun = time.monotonic()
    root = Root(folder / "empty")
    unpack(tar, root.place)
    (root.place / "tmp").mkdir()
    name = tar.name.removesuffix(".tar.gz")
    try_program("tar file", root, begun, [f"/{name}/bin/bladeoff"], f"/{name}/share/bladeoff/studies", "/tmp", expected)


def try_wheel(wheel, place, expected):
    begun = time.monotonic()
    root = Root(place)
    shutil.copy2(wheel, place)
    root.run("/usr/bin/python3", "-m", "venv", "/venv")
    root.run("/venv/bin/pip", "install", "--quiet", "--no-index", f"/{wheel.name}")
    try_program("wheel", root, begun, ["/venv/bin/bladeoff"], "/venv/share/bladeoff/studies", "/tmp", expected)


def try_dockerfile(artifact, place, expected):
    """Follows the instructions of packaging/Dockerfile in a root directory."""
    begun = time.monotonic()
    root, cwd, entry = Root(place), "/", []
    for line in (OUT / "Dockerfile").read_text().splitlines():
        word, _, rest = line.partition(" ")
        if word == "ADD":
            name, target = rest.split()
            unpack(OUT / name, place / target.lstrip("/"))
        elif word == "WORKDIR":
            cwd = rest
            (place / rest.lstrip("/")).mkdir(parents=True, exist_ok=True)
        elif word == "ENTRYPOINT":
            entry = json.loads(rest)
        elif word and not line.startswith("#") and line != "FROM scratch":
            sys.exit(f"packaging/Dockerfile: {word} is not tried by this script")
    studies = next(place.glob("bladeoff-*/share/bladeoff/studies")).relative_to(place)
    try_program(artifact, root, begun, entry, f"/{studies}", cwd, expected)


def expected_tables(folder):
    """The tables of the program of cargo build --release on this computer."""
    step("tables of cargo build --release")
    subprocess.run(["cargo", "build", "--release"], check=True, cwd=ROOT)
    (folder / "expected").mkdir()

    def run(word, study, *options):
        subprocess.run([ROOT / "target/release/bladeoff", word, ROOT / "studies" / study, *options], check=True, cwd=folder / "expected", stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return tables(run, lambda name: (folder / "expected" / name).read_bytes())


def check_artifacts(wheel, tar, folder):
    expected = expected_tables(folder)
    step("each artifact from the file to its first answer")
    if os.geteuid() != 0 or not shutil.which("unshare"):
        print("SKIPPED: no artifact is tried in a root directory of its own, which needs root and unshare", file=sys.stderr)
        return
    try_tar(tar, folder, expected)
    try_dockerfile("Dockerfile (empty root, as FROM scratch has)", folder / "scratch", expected)
    place = debian(folder)
    if place:
        try_wheel(wheel, place, expected)
        try_dockerfile("Dockerfile", place, expected)


def check_module(wheel, folder):
    step("tests and types of the Python module")
    venv = folder / "venv"
    subprocess.run([sys.executable, "-m", "venv", venv], check=True)
    subprocess.run([venv / "bin/pip", "install", "--quiet", "--disable-pip-version-check", f"{wheel}[polars,pandas]", "pytest", "mypy"], check=True)
    subprocess.run([venv / "bin/python", "-m", "pytest", "-q", "-p", "no:cacheprovider", ROOT / "python/tests"], check=True, cwd=folder)
    for checked in (["-p", "bladeoff"], [ROOT / "python/tests/test_bladeoff.py"]):
        mypy = [venv / "bin/python", "-m", "mypy", "--strict", "--ignore-missing-imports", "--cache-dir", folder / "mypy", *checked]
        subprocess.run(mypy, check=True, cwd=folder)
    step("the notebooks, cell by cell")
    subprocess.run([venv / "bin/pip", "install", "--quiet", "--disable-pip-version-check", "matplotlib"], check=True)
    notebooks = sorted((venv / "share/bladeoff/notebooks").iterdir())
    for path in notebooks:
        cells = [cell for cell in json.loads(path.read_text())["cells"] if cell["cell_type"] == "code"]
        script = "\n".join("".join(cell["source"]) for cell in cells)
        subprocess.run([venv / "bin/python", "-c", script], check=True, cwd=folder, env={**os.environ, "MPLBACKEND": "Agg"})
    if not notebooks:
        sys.exit("the wheel has no notebook")
