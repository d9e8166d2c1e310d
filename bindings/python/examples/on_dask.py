"""A sweep on Dask, whose client has `submit`, so that nothing else is needed; and the same on the threads of this process.

    pip install "dask[distributed]"; python examples/on_dask.py mesh.obj [poses]
"""

import sys
import time

import numpy as np
from dask.distributed import Client, LocalCluster

import pfront as pf

if __name__ == "__main__":
    mesh, count = pf.Mesh(sys.argv[1]), int((sys.argv[2:] or [100_000])[0])
    poses = np.tile(np.eye(4, dtype=np.float32), (count, 1, 1))
    poses[:, 0, 3] = np.linspace(0, 2, count) * np.ptp(mesh.vertices[:, 0])
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        for name, executor in (("Dask", client), ("threads", None)):
            began = time.perf_counter()
            hits = sum(hit for _, hit in pf.sweep(mesh, mesh, poses, executor=executor))
            print(f"{name}: {hits} of {count} poses meet; {time.perf_counter() - began:.2f} s")
