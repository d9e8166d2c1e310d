"""A sweep on Dask: its client has `submit`, so that nothing else is needed.

    pip install "dask[distributed]"; python examples/on_dask.py mesh.obj
"""

import sys

import numpy as np
from dask.distributed import Client, LocalCluster

import pfront as pf

if __name__ == "__main__":
    mesh = pf.Mesh(sys.argv[1])
    poses = np.tile(np.eye(4, dtype=np.float32), (100_000, 1, 1))
    poses[:, 0, 3] = np.linspace(0, 1, len(poses))
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        print(sum(hit for _, hit in pf.sweep(mesh, mesh, poses, executor=client, chunk=50_000)))
