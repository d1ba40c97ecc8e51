"""The command povgen chart."""

from pathlib import Path

import click

from povgen.cli import shared_options
from povgen.cli.field_options import Command
from povgen.progress import say
from povgen.record import save
from povgen.scene.presets import Chess


@click.command("chart", cls=Command)
@shared_options.output("FOLDER", "write charts and tables there", "chart")
def command(output: Path) -> None:
    """Measure the cost and the error of pictures, for every renderer and every sampling. Takes half an hour."""
    from povgen.measure import charts, speed  # slow to load: matplotlib

    with shared_options.made_folder(output, {"frames.csv": charts.FILES}) as folder:
        scenes = {"detailed": Chess(), "ideal": Chess(sheet="ideal")}
        charts.save_frames(speed.measure_samplings(scenes, say), folder)
        save(f"{speed.machine()}\n".encode(), folder / "machine.txt")
