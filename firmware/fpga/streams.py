"""beamformer.v and chain.v beside the chain's vectors, by cocotb with its AXI models: waits at random on each channel.

    python3 firmware/fpga/streams.py VECTORS

VECTORS is a folder of `host-sim golden`, with the tables of this one. Needs Icarus Verilog, cocotb and cocotbext-axi.
"""

import random
import sys
from pathlib import Path

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge, with_timeout
from cocotb_tools.runner import get_results, get_runner
from cocotbext.axi import AxiLiteBus, AxiLiteMaster, AxiStreamBus, AxiStreamFrame, AxiStreamSink, AxiStreamSource

HERE = Path(__file__).resolve().parent
LINES, VALUES, STATUS = 3, 20, 4 * 31
QUIET = {"COCOTB_LOG_LEVEL": "WARNING", "PYTHONWARNINGS": "ignore"}


def words(name):
    return [bytes.fromhex(line)[::-1] for line in Path(name).read_text().split()]


def waits(share, seed):
    """Whether to wait, for each clock: short gaps and long ones."""
    draw = random.Random(seed)
    while True:
        yield from [draw.random() < share] * (1 if draw.random() < 0.95 else draw.randrange(400))


async def held(dut):
    """A word that is offered stays until it is taken."""
    offered = None
    while True:
        await RisingEdge(dut.clock)
        valid, word = dut.m_axis_tvalid.value, (dut.m_axis_tdata.value, dut.m_axis_tlast.value)
        assert offered is None or (valid and word == offered), "a word did not wait"
        offered = word if valid and not dut.m_axis_tready.value else None


@cocotb.test()
@cocotb.parametrize(share=[0.0, 0.5])
async def lines(dut, share):
    packs = hasattr(dut, "s_axis_tuser")
    core = dut.beamformer if packs else dut
    blocks, values, expected = (words(f"chain.{name}.hex") for name in ("in", "lines", "out"))
    beats, outputs = VALUES * len(blocks) // len(values), int.from_bytes(values[0], "little")
    cocotb.start_soon(Clock(dut.clock, 10, "ns").start())
    dut.reset.value = 1
    if packs:
        for name, value in dict(enable=1, start=0, beam=0, epoch=0, waits=1).items():
            getattr(dut, name).value = value
    source = AxiStreamSource(AxiStreamBus.from_prefix(dut, "s_axis"), dut.clock, dut.reset)
    sink = AxiStreamSink(AxiStreamBus.from_prefix(dut, "m_axis"), dut.clock, dut.reset)
    axil = AxiLiteMaster(AxiLiteBus.from_prefix(dut, "s_axil"), dut.clock, dut.reset)
    channels = [source, sink, axil.write_if.aw_channel, axil.write_if.w_channel, axil.write_if.b_channel]
    channels += [axil.read_if.ar_channel, axil.read_if.r_channel]
    for seed, channel in enumerate(channels):
        channel.set_pause_generator(waits(share, seed))
    await ClockCycles(dut.clock, 5)
    dut.reset.value = 0
    cocotb.start_soon(held(dut))

    async def counted(least):
        while await axil.read_dword(STATUS) < least:
            pass

    async def send():
        for line in range(LINES):
            block = blocks[beats * line : beats * (line + 1)]
            if packs:
                # A bank of the packer is free.
                await counted(line - 1)
                dut.start.value = 1
                await RisingEdge(dut.clock)
                dut.start.value = 0
                block = block[1:-3]
            await source.send(AxiStreamFrame(b"".join(block), tuser=0 if packs else None))
            await source.wait()
    cocotb.start_soon(send())
    for line in range(LINES):
        while core.state.value != 0:
            await ClockCycles(dut.clock, 20)
        # A register is written whole, or not.
        await axil.write(4, b"\xff\xff")
        numbers = values[VALUES * line : VALUES * (line + 1)]
        for k, number in enumerate([*numbers, bytes(4)]):
            await axil.write(4 * (k + 1), number)
        assert (await axil.read(4, 4 * VALUES)).data == b"".join(numbers)
        await axil.write(0, b"\1\0\0\0")
        await counted(line + 1)
        await axil.write(0, bytes(4))
    for line in range(LINES):
        frame = await with_timeout(sink.recv(), 20, "ms")
        assert bytes(frame.tdata) == b"".join(expected[outputs * line : outputs * (line + 1)]), f"line {line}"
    await ClockCycles(dut.clock, 3000)
    assert sink.empty()


def main():
    vectors = Path(sys.argv[1]).resolve()
    lines = [len((vectors / name).read_text().split()) for name in ("chain.in.hex", "chain.lines.hex")]
    samples = lines[0] * VALUES // lines[1] // 8
    runner = get_runner("icarus")
    sources = [path for path in sorted(HERE.glob("*.v")) if not path.stem.endswith("_tb") and path.stem != "handshakes"]
    for top in ("beamformer", "chain"):
        folder = vectors / f"streams-{top}"
        options = {"parameters": {"SAMPLES": samples}, "timescale": ("1ns", "1ns"), "build_dir": folder}
        runner.build(sources=sources, hdl_toplevel=top, always=True, **options)
        results = runner.test("streams", top, build_dir=folder, test_dir=vectors, extra_env=QUIET)
        tests, failed = get_results(results)
        print(f"streams: {top}, {tests} tests, {failed} errors")
        assert tests and not failed


if __name__ == "__main__":
    main()
