"""The file format: datasets and attributes of every kind of file, from the declarations that check them."""

from collections.abc import Iterable, Iterator, Mapping

from from_code.attribute_meanings import MEANINGS
from from_code.markdown import code, plain, table
from vibsim.cases import load_case
from vibsim.evidence.benchmark import bench_result
from vibsim.fitting import plan as fit_plan
from vibsim.fitting.plan import Search
from vibsim.fitting.plan import make_plan as make_fit_plan
from vibsim.orbits.branches import curve as branch_structure
from vibsim.results import trajectory_file
from vibsim.results.columns import JUDGEMENTS, tables_of
from vibsim.results.file_contents import Attribute, Dataset
from vibsim.sweeps import sweep_file
from vibsim.sweeps.quantities import DEFINITIONS
from vibsim.sweeps.sweeping import make_plan as make_sweep_plan

HEAD = """# File format

Every file is HDF5 and follows the CF conventions: a dataset has `units` and `long_name`, codes have
`flag_values` and `flag_meanings`, the root attributes `vibsim_kind` and `vibsim_format` say what the file is.
It can be opened by h5py, xarray, MATLAB, h5dump and anything else that reads HDF5. Files are checked against
the tables below when they are opened; a file that differs is refused with one line that names the part.

Types: `f8` is a double, `i1` to `i8` are whole numbers of as many bytes, `S` and `text` are texts. An
attribute marked *optional* is left out where its value is not known; nothing in a file is made up.
"""
OPTIONAL = {True: "optional", False: ""}


def page() -> str:
    """The page of all kinds of files."""
    return "\n".join([HEAD, *_trajectory(), *_sweep(), *_branch(), *_fit(), *_bench()])


def _trajectory() -> Iterator[str]:
    yield "## Runs (`vibsim_kind` = trajectory)\n"
    for name, what in (
        ("II-B", "the paper's two blocks with a motor"),
        ("gallery/energy-sink", "named parts with rigid stops"),
    ):
        tables = tables_of(load_case(name).scene()).judged(JUDGEMENTS)
        yield f"### Datasets of {code(name)}: {what}\n"
        yield _datasets([*trajectory_file.sample_datasets(tables), *trajectory_file.event_datasets(tables)])
    yield (
        "A run with `--digits` also holds the decimal texts of all states under `digits/`, those of the\n"
        "events under `digits/events/`. What an instant has between two samples can be evaluated again from\n"
        "the event before it.\n"
    )
    yield "### Datasets of a periodic orbit\n"
    yield "A stored orbit (`vibsim orbit -o`) is a run of one period, and holds besides:\n"
    yield _datasets([*trajectory_file.DATASETS, *trajectory_file.DIGITS])
    yield "The last three are there where the orbit was refined with `--digits`.\n"
    yield "### Attributes of runs\n"
    yield _attributes(trajectory_file.ATTRIBUTES)
    yield (
        "Beside these stand the entries of the energy ledger [J]: `energy_start`, `energy_end`,\n"
        "`work_source`, `work_base`, `work_belt`, `loss_viscous`, `loss_friction`, `loss_stops`, and one\n"
        "entry for each part, such as `work.forces.drive` or `loss.links.spring`.\n"
    )


def _sweep() -> Iterator[str]:
    axes = [("Omega0", "5:6:0.5 Hz", "", "Omega0"), ("c", "0.01:0.02/2", "", "c")]
    plan = make_sweep_plan(load_case("II-B"), axes, compute="all")
    yield "## Sweeps (`vibsim_kind` = sweep)\n"
    yield "### Datasets of a sweep of `II-B` over Omega0 and c, with `--compute all`\n"
    yield plain(DEFINITIONS) + "\n"
    yield _datasets(sweep_file.datasets_of(plan))
    yield "### Attributes of sweeps\n"
    yield _attributes(sweep_file.ATTRIBUTES)


def _branch() -> Iterator[str]:
    yield "## Branches (`vibsim_kind` = branch)\n"
    yield "### Datasets of a branch over a frequency\n"
    yield _datasets(branch_structure.datasets_of("Hz"))
    yield "### Attributes of branches\n"
    yield _attributes(branch_structure.ATTRIBUTES)
    yield "## Loci (`vibsim_kind` = locus)\n"
    yield "### Datasets of a locus over a frequency and a damping\n"
    yield _datasets(branch_structure.locus_datasets("Hz", "N s/m"))
    yield "### Attributes of loci\n"
    yield _attributes(branch_structure.LOCUS_ATTRIBUTES)


def _fit() -> Iterator[str]:
    statements = ["captured until the end"]
    plan = make_fit_plan([load_case("II-B")], {"J": "0.5:20 g m^2"}, statements, (), {}, 0, {}, Search())
    yield "## Fits (`vibsim_kind` = fit)\n"
    yield "### Datasets of a fit of `II-B` with J free\n"
    yield _datasets(fit_plan.datasets_of(plan))
    yield "### Attributes of fits\n"
    yield _attributes(fit_plan.ATTRIBUTES)


def _bench() -> Iterator[str]:
    yield "## Benches (`vibsim_kind` = bench)\n"
    yield "### Datasets of a bench of `II-B`\n"
    yield _datasets(bench_result.datasets_of(load_case("II-B").scene()))
    yield "### Attributes of benches\n"
    yield _attributes(bench_result.ATTRIBUTES)


def _datasets(datasets: Iterable[Dataset]) -> str:
    rows = [
        (
            code(dataset.name),
            ", ".join(dataset.dims),
            code(dataset.column.dtype),
            plain(dataset.column.units or ""),
            plain(dataset.column.long_name + _flags(dataset.column.flags)),
        )
        for dataset in datasets
    ]
    return table(("dataset", "dimensions", "type", "unit", "meaning"), rows)


def _flags(flags: Mapping[str, int]) -> str:
    return f" ({', '.join(f'{value}: {word}' for word, value in flags.items())})" if flags else ""


def _attributes(attributes: Iterable[Attribute]) -> str:
    rows = [(code(item.name), item.kind, OPTIONAL[item.optional], MEANINGS[item.name]) for item in attributes]
    return table(("attribute", "holds", "", "meaning"), rows)
