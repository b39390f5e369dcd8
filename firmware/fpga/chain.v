// From the samples of transmits to complex lines: packer.v, and beamformer.v behind it. See docs/fpga.md.
module chain #(
    parameter SAMPLES = 280,       // of a transmit
    parameter BITS = 16            // of a number
) (
    input wire clock,
    input wire reset,
    input wire enable,             // see packer.v, from here on
    input wire start,
    input wire [15:0] beam,
    input wire [7:0] epoch,
    input wire [32*BITS-1:0] s_axis_tdata,
    input wire [1:0] s_axis_tuser,
    input wire s_axis_tvalid,
    output wire s_axis_tready,
    input wire waits,
    input wire [6:0] s_axil_awaddr,        // see beamformer.v, from here on
    input wire s_axil_awvalid,
    output wire s_axil_awready,
    input wire [31:0] s_axil_wdata,
    input wire [3:0] s_axil_wstrb,
    input wire s_axil_wvalid,
    output wire s_axil_wready,
    output wire [1:0] s_axil_bresp,
    output wire s_axil_bvalid,
    input wire s_axil_bready,
    input wire [6:0] s_axil_araddr,
    input wire s_axil_arvalid,
    output wire s_axil_arready,
    output wire [31:0] s_axil_rdata,
    output wire [1:0] s_axil_rresp,
    output wire s_axil_rvalid,
    input wire s_axil_rready,
    output wire [63:0] m_axis_tdata,
    output wire m_axis_tvalid,
    input wire m_axis_tready,
    output wire m_axis_tlast
);
    wire [63:0] beat;
    wire beat_valid, beat_ready, beat_last;
    packer #(32, BITS, SAMPLES) packer (clock, reset, enable, start, beam, epoch, s_axis_tdata, s_axis_tuser,
        s_axis_tvalid, s_axis_tready, waits, beat, beat_valid, beat_ready, beat_last);
    beamformer #(SAMPLES, BITS) beamformer (clock, reset, s_axil_awaddr, s_axil_awvalid, s_axil_awready, s_axil_wdata,
        s_axil_wstrb, s_axil_wvalid, s_axil_wready, s_axil_bresp, s_axil_bvalid, s_axil_bready, s_axil_araddr,
        s_axil_arvalid, s_axil_arready, s_axil_rdata, s_axil_rresp, s_axil_rvalid, s_axil_rready, beat, beat_valid,
        beat_ready, beat_last, m_axis_tdata, m_axis_tvalid, m_axis_tready, m_axis_tlast);
endmodule
