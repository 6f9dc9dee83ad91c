"""The folder of a study: results as Zarr 3, one table as Parquet, and what the study is.

    study.json       what is computed, with its hash and the versions
    results.zarr     an array for each result; its chunks are those of the study, so that a worker writes whole chunks
    parts/*.parquet  the table rows of each chunk that is complete; the file is written after the chunk's results
    runs.parquet     the table of all runs, at the end, when the parts are removed

Every file is written beside its place, synchronised to the disk and renamed. A chunk without its part is computed
again. Chunks hold a checksum (CRC-32C), so that a damaged one cannot be read.
"""

import json
import os
import shutil
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from fmus.support.errors import InputError, MissingToolError
from fmus.support.files import note_written, write_atomically
from motofmi.studies.runs import Computed, Runs

STUDY, RESULTS, TABLE, PARTS = "study.json", "results.zarr", "runs.parquet", "parts"
EXTRA = "studies are stored as Zarr and Parquet: pip install 'motofmi[scale]'"


class Store:
    """The folder of a study of given runs."""

    def __init__(self, folder: Path, runs: Runs):
        self.folder, self.runs = Path(folder).absolute(), runs

    @property
    def table(self) -> Path:
        """The path of the table of all runs."""
        return self.folder / TABLE

    @property
    def results(self) -> Path:
        """The path of the Zarr store."""
        return self.folder / RESULTS

    def begin(self, description: dict[str, Any]) -> None:
        """Create the folder, or check that it holds the same study. Raises InputError where it holds another one."""
        missing_extra()
        path = self.folder / STUDY
        text = json.dumps(description, indent=1, sort_keys=True) + "\n"
        if path.exists():
            _same(path, json.loads(path.read_text("utf-8")), description)
        elif self.folder.exists() and any(self.folder.iterdir()):
            raise InputError(f"{self.folder} holds other files and no {STUDY}: give --out a new folder")
        else:
            write_atomically(path, lambda beside: _write_bytes(beside, text.encode()))
        if not self.results.exists():
            unfinished = self.results.with_suffix(".partial")
            shutil.rmtree(unfinished, ignore_errors=True)
            self._create(unfinished)
            unfinished.rename(self.results)
        note_written(path)

    def _create(self, path: Path) -> None:
        """The arrays with their attributes, without values."""
        import zarr  # noqa: PLC0415 - of the extra
        from zarr.codecs import Crc32cCodec, ZstdCodec  # noqa: PLC0415

        codecs = (ZstdCodec(level=1), Crc32cCodec())
        group = zarr.open_group(path, mode="w", zarr_format=3)
        grid = self.runs.grid
        for name, result in self.runs.results.items():
            group.create_array(
                name, shape=grid.shape + result.shape, chunks=grid.chunk + result.shape, dtype=result.dtype,
                fill_value=result.absent, dimension_names=grid.dims + result.dims, compressors=codecs,
                attributes={"units": result.unit, "long_name": result.meaning},
            )  # fmt: skip
        for name, coordinate in self.runs.coordinates.items():
            values = np.asarray(coordinate.values)
            if values.dtype.kind == "U":
                values = values.astype(np.dtypes.StringDType())
            group.create_array(name, data=values, dimension_names=(coordinate.dim,), compressors=codecs,
                               attributes={"units": coordinate.unit, "long_name": coordinate.meaning})  # fmt: skip

    def reachable(self) -> None:
        """Raises InputError where a worker does not see the folder."""
        if not (self.folder / STUDY).exists():
            raise InputError(f"a worker does not see {self.folder}: give --out a folder that all workers share")

    def write(self, chunk: int, computed: Computed) -> None:
        """Write the results of a chunk, then its rows. Raises InputError where they cannot be written."""
        import zarr  # noqa: PLC0415 - of the extra

        grid = self.runs.grid
        region = grid.region(chunk)
        box = tuple(part.stop - part.start for part in region)
        try:
            for name, values in computed.arrays.items():
                with zarr.config.set({"array.write_empty_chunks": True}):  # a missing file is a chunk to compute
                    array = zarr.open_array(self.results / name, mode="r+")
                    array[region] = values.reshape(box + values.shape[1:])
                _synchronise(self._chunk_file(name, chunk))
            write_atomically(self.part(chunk), lambda beside: self._write_rows(beside, chunk, computed), cache=True)
        except OSError as error:
            raise InputError(f"cannot write {self.results}: {error.strerror or error}; what is complete is kept: "
                             "free space there and start the study again") from None  # fmt: skip

    def _chunk_file(self, name: str, chunk: int) -> Path:
        zeros = len(self.runs.results[name].shape)
        return self.results / name / "c" / "/".join(map(str, (*self.runs.grid.place(chunk), *[0] * zeros)))

    def part(self, chunk: int) -> Path:
        """The path of the rows of a chunk."""
        return self.folder / PARTS / f"{chunk:08d}.parquet"

    def _schema(self) -> Any:
        import pyarrow as pa  # noqa: PLC0415 - of the extra

        types = {"string": pa.string(), "float64": pa.float64(), "int64": pa.int64(), "bool": pa.bool_()}
        return pa.schema([pa.field(name, types[column.dtype], metadata={"unit": column.unit})
                          for name, column in self.runs.columns.items()])  # fmt: skip

    def _write_rows(self, path: Path, chunk: int, computed: Computed) -> None:
        import pyarrow as pa  # noqa: PLC0415 - of the extra
        import pyarrow.parquet as pq  # noqa: PLC0415

        columns = {name: computed.columns[name] for name in self.runs.columns}
        pq.write_table(pa.table(columns, schema=self._schema()), path)
        _synchronise(path)

    def incomplete(self) -> list[int]:
        """The numbers of the chunks that are not complete, or cannot be read. Leftovers of interrupted writes are
        removed."""
        for pattern in (f"{RESULTS}/**/*.partial", f"{PARTS}/.*", ".runs-*", ".study-*"):
            for left in self.folder.glob(pattern):
                if left.is_file():
                    left.unlink()
        finished = self.table.exists() and _readable(self.table)
        return [k for k in range(self.runs.grid.chunks)
                if not (finished or _readable(self.part(k))) or not self._results_readable(k)]  # fmt: skip

    def _results_readable(self, chunk: int) -> bool:
        """Whether all results of a chunk can be read, with their checksums."""
        import zarr  # noqa: PLC0415 - of the extra

        region = self.runs.grid.region(chunk)
        for name in self.runs.results:
            if not self._chunk_file(name, chunk).exists():
                return False
            try:
                zarr.open_array(self.results / name, mode="r")[region]
            except Exception:  # whatever the codecs raise for damaged bytes
                return False
        return True

    def finish(self) -> None:
        """Join the rows of all chunks into one table, and remove the parts. Raises InputError where it cannot be
        written."""
        import pyarrow.parquet as pq  # noqa: PLC0415 - of the extra

        def join(path: Path) -> None:
            with pq.ParquetWriter(path, self._schema()) as writer:
                for rows in self._joined():
                    writer.write_table(rows)
            _synchronise(path)

        if not (self.table.exists() and _readable(self.table)):
            write_atomically(self.table, join)
        note_written(self.table)
        shutil.rmtree(self.folder / PARTS, ignore_errors=True)

    def _joined(self, most: int = 50_000) -> Iterator[Any]:
        """The rows of the parts, ordered by chunk, as tables of about so many rows."""
        import pyarrow as pa  # noqa: PLC0415 - of the extra
        import pyarrow.parquet as pq  # noqa: PLC0415

        held: list[Any] = []
        for chunk in range(self.runs.grid.chunks):
            held.append(pq.read_table(self.part(chunk), partitioning=None))
            if sum(map(len, held)) >= most:
                yield pa.concat_tables(held).combine_chunks()
                held = []
        if held:
            yield pa.concat_tables(held).combine_chunks()


def missing_extra() -> None:
    """Raises MissingToolError where the packages of the extra are missing."""
    try:
        import pyarrow.parquet  # noqa: F401, PLC0415
        import zarr  # noqa: F401, PLC0415
    except ImportError:
        raise MissingToolError(EXTRA) from None


def _same(path: Path, held: dict[str, Any], wanted: dict[str, Any]) -> None:
    if held == json.loads(json.dumps(wanted)):
        return
    keys = [key for key in sorted(held.keys() | wanted.keys()) if held.get(key) != wanted.get(key) and key != "hash"]
    described = "; ".join(f"{key} was {_short(held.get(key))}, is {_short(wanted.get(key))}" for key in keys)
    raise InputError(
        f"{path.parent} holds another study ({described}): give --out a new folder, or the study as it was"
    )


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) < 80 else text[:77] + "..."


def _write_bytes(path: Path, contents: bytes) -> None:
    path.write_bytes(contents)
    _synchronise(path)


def _synchronise(path: Path) -> None:
    """Wait until the file is on the disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        with suppress(OSError):  # of file systems that cannot
            os.fsync(handle)
    finally:
        os.close(handle)


def _readable(path: Path) -> bool:
    import pyarrow.parquet as pq  # noqa: PLC0415 - of the extra

    try:
        pq.read_metadata(path)
    except Exception:  # missing, cut off or damaged
        return False
    return True
