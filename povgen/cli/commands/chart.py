"""The command povgen chart."""

from pathlib import Path
from typing import Annotated

from povgen.cli.options import made_folder, output_to
from povgen.files import save
from povgen.progress import say
from povgen.scene.scenes import Chess


def command(
    output: Annotated[Path, output_to("FOLDER", "write charts and tables there")] = Path("chart"),
) -> None:
    """Measure the cost and the error of pictures, for every renderer and every sampling. Takes half an hour."""
    from povgen.measure import charts, speed  # slow to load: matplotlib

    with made_folder(output, {"frames.csv": charts.FILES}) as folder:
        scenes = {"detailed": Chess(), "ideal": Chess(sheet="ideal")}
        charts.save_frames(speed.measure_samplings(scenes, say), folder)
        save(f"{speed.machine()}\n".encode(), folder / "machine.txt")
