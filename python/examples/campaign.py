# %% [markdown]
# A campaign: the same point beamformed with several β and diagonal loadings, by the workflow of `campaigns/`, and its
# table as a figure. Run as a script, or cell by cell in an editor that knows `# %%`.
#
#     pip install ./python[examples] snakemake
#     cargo install --path host-sim --locked
#     python python/examples/campaign.py [FIGURE.png [FOLDER]]
#
# A campaign that is stopped, even by `kill -9`, goes on when it is started again in the same folder.

# %%
import csv
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt

CAMPAIGNS = Path(__file__).resolve().parents[2] / "campaigns"
SWEEP: dict[str, list[float]] = {
    "seed": [1, 2],
    "beta": [0.3, 0.03, 0.003, 0.0003],
    "diagonal_loading": [0.1, 0.01],
    "threshold": [15],
}
CONFIG = {
    "host_sim": os.environ.get("HOST_SIM", "host-sim"),
    "simulate": "point --beams 33 --beam-step 0.5 --first-beam 56 --noise -30",
    "beamform": "--method esmv --depth-start 0.013 --depth-end 0.017 --rows 64 --columns 64",
    "phase_symmetry": "--scales 2^-4",
    "sweep": SWEEP,
}


# %%
def table(folder):
    """The rows of the campaign's table, which is made in that folder."""
    config = Path(folder) / "config.json"
    config.write_text(json.dumps(CONFIG))
    words = ["snakemake", "--snakefile", CAMPAIGNS / "Snakefile", "--directory", folder, "--cores", "all"]
    subprocess.run([*words, "--configfile", config], check=True)
    with open(Path(folder) / "out/table.csv", newline="") as file:
        return list(csv.DictReader(file))


with tempfile.TemporaryDirectory() as new:
    rows = table(sys.argv[2] if len(sys.argv) > 2 else new)

# %% Width of the point over β, a line a loading: the mean over the seeds.
figure, ax = plt.subplots(figsize=(5, 3.6), layout="constrained")
for loading in SWEEP["diagonal_loading"]:
    widths = []
    for beta in SWEEP["beta"]:
        of_both = [row for row in rows if (float(row["diagonal_loading"]), float(row["beta"])) == (loading, beta)]
        widths.append(sum(1e3 * float(row["point.width_6db_m"]) for row in of_both) / len(of_both))
    ax.semilogx(SWEEP["beta"], widths, "o-", label=f"Δ = {loading}")
ax.set(xlabel="β", ylabel="−6 dB width of the point, mm", ylim=(0, None))
ax.legend()
ax.set_title(f"{len(rows)} runs of version {rows[0]['version']}", fontsize=9)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "campaign.png", dpi=70)
print(f"{len(rows)} runs")
