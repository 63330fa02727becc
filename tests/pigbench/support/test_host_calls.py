"""Calls into Python, against what NumPy and `jax.pure_callback` make of the same function."""

import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from pigbench.support.host_calls import host_call

FLOATS = np.arange(6, dtype=np.float32).reshape(2, 3)


def double(tree):
    return {"sum": tree["x"] + tree["count"][..., None], "none": ~tree["flag"]}


TREE = {
    "x": jnp.asarray(FLOATS),
    "count": jnp.array([10, 20], jnp.int32),
    "flag": jnp.array([True, False]),
}
RESULTS = {
    "sum": jax.ShapeDtypeStruct((3,), jnp.float32),
    "none": jax.ShapeDtypeStruct((), bool),
}


def call(tree):
    return host_call("double", double, RESULTS, tree)


def test_trees_of_each_dtype_go_there_and_back():
    found = jax.jit(jax.vmap(call))(TREE)
    np.testing.assert_array_equal(found["sum"], FLOATS + np.array([[10], [20]]))
    np.testing.assert_array_equal(found["none"], [False, True])
    assert (found["sum"].dtype, found["none"].dtype) == (np.float32, bool)


def test_a_call_is_what_a_callback_is():
    tree = jax.tree.map(lambda x: jnp.stack([x, x[::-1]]), TREE)
    callback = lambda tree: jax.pure_callback(  # noqa: E731
        double, RESULTS, tree, vmap_method="broadcast_all"
    )
    found, expected = (jax.jit(jax.vmap(jax.vmap(f)))(tree) for f in (call, callback))
    jax.tree.map(np.testing.assert_array_equal, found, expected)


def test_what_is_not_batched_is_given_once_for_each():
    shapes = []

    def look(x, y):
        shapes.append((x.shape, y.shape))
        return x + y

    shape = jax.ShapeDtypeStruct((3,), jnp.float32)
    one = jnp.arange(3.0)
    found = jax.vmap(lambda x: host_call("look", look, shape, x, one))(jnp.asarray(FLOATS))
    np.testing.assert_array_equal(found, FLOATS + np.arange(3))
    assert shapes == [((2, 3), (2, 3))]


def test_scalars_and_empty_arrays():
    def add(x, empty):
        return x + 1, empty

    x, empty = jnp.float32(1), jnp.zeros((0, 3))
    found = jax.jit(lambda *args: host_call("add", add, (x, empty), *args))(x, empty)
    assert found[0] == 2
    assert found[1].shape == (0, 3)


SHAPE = jax.ShapeDtypeStruct((3,), jnp.float32)


def fails(function, results=SHAPE, x=None):
    """The message of the error with which a call fails."""
    x = jnp.ones(3) if x is None else x
    name = f"{function.__qualname__} {function.__code__.co_firstlineno}"
    with pytest.raises(jax.errors.JaxRuntimeError) as caught:
        jax.block_until_ready(jax.jit(lambda x: host_call(name, function, results, x))(x))
    return str(caught.value)


def test_an_exception_is_jaxs_and_says_what_it_was():
    def fail(x):
        raise ValueError("no such luck in \udcff")  # as in a name of a file that is not text

    assert re.search(r"in fail(.|\n)*no such luck in \\udcff", fails(fail))


def test_results_that_do_not_fit_are_errors():
    whole = jax.ShapeDtypeStruct((3,), jnp.int32)
    assert "shorter" in fails(lambda x: (x,), results=(SHAPE, SHAPE))
    assert "shape (1, 3) instead of (3,)" in fails(lambda x: x[None])
    assert "Cannot cast" in fails(lambda x: x + 0.5, results=whole)


def test_arguments_cannot_be_written_to():
    def spoil(x):
        x[:] = 7
        return x

    x = jnp.ones(3)
    assert "read-only" in fails(spoil, x=x)
    np.testing.assert_array_equal(x, 1)


@pytest.mark.parametrize("dtype", [np.uint8, np.float16])
def test_other_dtypes(dtype):
    x = jnp.arange(3, dtype=dtype)
    found = jax.jit(lambda x: host_call(f"next {dtype}", lambda x: x + dtype(1), x, x))(x)
    assert found.dtype == dtype
    np.testing.assert_array_equal(found, [1, 2, 3])


def test_in_loops_and_from_several_threads():
    @jax.jit
    def run(x):
        step = lambda x: host_call("next", lambda x: x + 1, x, x)  # noqa: E731
        return jax.lax.fori_loop(0, 100, lambda _, x: step(x), x)

    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(run, [jnp.full(5, float(i)) for i in range(8)]))
    np.testing.assert_array_equal(found, np.arange(8.0)[:, None] + np.full(5, 100.0))


CACHED = """
import sys, jax, jax.numpy as jnp
from pigbench.support.host_calls import host_call
jax.config.update("jax_compilation_cache_dir", sys.argv[1])
jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
jax.monitoring.register_event_listener(
    lambda event, **_: "cache_hits" in event and print("from the cache"))
x = jnp.arange(3.0)
print(jax.jit(lambda x: host_call("times", lambda x: x * float(sys.argv[2]), x, x))(x))
"""

# The program calls for a second or so after Python has begun to end. It multiplies matrices, since
# XLA runs one that hardly computes on the main thread, which would wait for it.
LEAVING = """
import time, jax, jax.numpy as jnp
from pigbench.support.host_calls import host_call
def wait(x):
    time.sleep(0.01)
    return x
step = lambda _, x: host_call("wait", wait, x, x @ x / 100)
jax.jit(lambda x: jax.lax.fori_loop(0, 100, step, x))(jnp.ones((100, 100)))
print("left")
"""

# A signal that comes while XLA runs on the main thread is raised before the call's first line.
SIGNALS = """
import signal, time, jax, jax.numpy as jnp
from pigbench.support.host_calls import host_call
def hear(_, frame):
    if frame.f_code.co_name == "_work":
        raise KeyboardInterrupt
call = jax.jit(lambda x: host_call("same", lambda x: x, x, x))
x = jnp.ones(3)
call(x).block_until_ready()
signal.signal(signal.SIGALRM, hear)
signal.setitimer(signal.ITIMER_REAL, 0.0003, 0.0007)
errors, end = 0, time.monotonic() + 2
while time.monotonic() < end:
    try:
        call(x).block_until_ready()
    except jax.errors.JaxRuntimeError:
        errors += 1
signal.setitimer(signal.ITIMER_REAL, 0)
print("survived" if errors else "no signal came")
"""

DEVICES = """
import jax, jax.numpy as jnp
from jax.sharding import Mesh, NamedSharding, PartitionSpec
from pigbench.support.host_calls import host_call
jax.config.update("jax_num_cpu_devices", 2)
mesh = Mesh(jax.devices(), ("batch",))
x = jax.device_put(jnp.arange(4.0), NamedSharding(mesh, PartitionSpec("batch")))
print(jax.jit(jax.vmap(lambda x: host_call("double", lambda x: 2 * x, x, x)))(x))
"""


def run(code: str, *arguments: object) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [sys.executable, "-P", "-c", code, *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=120,
    )


def test_a_compiled_program_serves_the_next_process(tmp_path):
    first, second = run(CACHED, tmp_path, 2), run(CACHED, tmp_path, 3)
    assert first.stdout == "[0. 2. 4.]\n", first.stderr
    assert second.stdout.splitlines()[-1] == "[0. 3. 6.]", second.stderr
    assert "from the cache" in second.stdout


def test_python_ends_while_a_program_calls():
    done = run(LEAVING)
    assert (done.returncode, done.stdout, done.stderr) == (0, "left\n", "")


def test_signals_are_errors():
    done = run(SIGNALS)
    assert (done.returncode, done.stdout) == (0, "survived\n"), done.stderr[-2000:]


def test_several_devices():
    done = run(DEVICES)
    assert done.stdout == "[0. 2. 4. 6.]\n", done.stderr
