"""Parallel jobs on this machine or a Dask cluster, and child processes."""

from .children import Child as Child
from .cluster import use_cluster as use_cluster
from .runners import Runner as Runner
from .runners import Serial as Serial
from .runners import parallel as parallel
from .runners import worker_count as worker_count
