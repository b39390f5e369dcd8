// From blocks of firmware/stream to complex lines of MV, rank-1 ESMV or DAS: receive delays, interpolation, covariance,
// solver. One beam a block; its parameters are registers. See docs/fpga.md.
module beamformer #(
    parameter SAMPLES = 280,       // of a block
    parameter BITS = 16,           // of a count
    parameter PHASORS = "phasors.hex",
    parameter FORM = "real_form.hex",
    parameter PROGRAM = "solver.hex",
    parameter RECIPROCALS = "reciprocals.hex"
) (
    input wire clock,
    input wire reset,
    input wire [6:0] s_axil_awaddr,
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
    input wire [63:0] s_axis_tdata,        // as packer.v sends it, of 16 elements' I/Q
    input wire s_axis_tvalid,
    output wire s_axis_tready,
    input wire s_axis_tlast,
    output wire [63:0] m_axis_tdata,       // {im, re}, 2^-10 of a count
    output wire m_axis_tvalid,
    input wire m_axis_tready,
    output wire m_axis_tlast               // of the line
);
    localparam ELEMENTS = 16;
    localparam N = $clog2(SAMPLES);
    localparam [N-1:0] LAST_SAMPLE = SAMPLES[N-1:0] - 1'b1;

    // --- Registers, by their numbers; those of 64 bits have the lower half first.
    reg [31:0] blocks;
    wire [32*32-1:0] values;
    wire [15:0] outputs = values[32*1 +: 16];           // samples of a line, from 1 on
    wire [15:0] loading = values[32*2 +: 16];           // delta/8, 2^-20
    wire [27:0] rate = values[32*3 +: 28];
    wire [51:0] first_position = values[32*4 +: 52];    // see delay_interpolate.v
    wire [51:0] step_position = values[32*6 +: 52];
    wire [43:0] first_cycles = values[32*8 +: 44];
    wire [43:0] step_cycles = values[32*10 +: 44];
    wire [34:0] depth = values[32*12 +: 35];            // see receive_delays.v
    wire [34:0] depth_step = values[32*14 +: 35];
    wire [34:0] across = values[32*16 +: 35];
    wire [34:0] pitch = values[32*18 +: 35];
    wire [9:0] first = values[32*20 +: 10];             // see solver.v
    wire runs = values[0];                              // low: no block is begun
    wire unused = &values;
    registers #(32) axil (clock, reset, s_axil_awaddr, s_axil_awvalid, s_axil_awready, s_axil_wdata, s_axil_wstrb,
        s_axil_wvalid, s_axil_wready, s_axil_bresp, s_axil_bvalid, s_axil_bready, s_axil_araddr, s_axil_arvalid,
        s_axil_arready, s_axil_rdata, s_axil_rresp, s_axil_rvalid, s_axil_rready, blocks, values);

    // --- A block to the record: two elements a beat.
    wire [64:0] beat;
    wire beat_valid, beat_ready;
    skid #(65) arriving (clock, reset, {s_axis_tlast, s_axis_tdata}, s_axis_tvalid, s_axis_tready, beat, beat_valid, beat_ready);
    localparam [1:0] HEADER = 0, LOAD = 1, START = 2, LINE = 3;
    reg [1:0] state;
    reg half, whole;               // the second element of a beat; the record is whole
    reg [N-1:0] sample;
    reg [3:0] element;
    wire loads = state == LOAD && beat_valid;
    wire line_done;
    // Of the line whose samples are in the covariance and the solver, which the next one waits for.
    reg solving;
    reg [9:0] line_first;
    reg [15:0] line_loading;
    wire line_solved;
    wire begins = state == START && !solving;
    assign beat_ready = state == HEADER ? runs : state == LOAD && (half || whole);
    reg write;
    reg [N-1:0] write_sample;
    reg [3:0] write_element;
    reg [2*BITS-1:0] write_word;
    reg start;
    always @(posedge clock) begin
        write <= loads && !whole;
        write_sample <= sample;
        write_element <= element;
        write_word <= half ? {beat[32 +: BITS], beat[48 +: BITS]} : {beat[0 +: BITS], beat[16 +: BITS]};
        start <= begins;
        if (begins) {line_first, line_loading} <= {first, loading};
        solving <= begins || solving && !line_solved;
        case (state)
            HEADER: if (beat_valid && runs) state <= LOAD;
            LOAD: if (beat_valid) begin
                if (!whole) begin
                    half <= !half;
                    element <= element + 1'b1;
                    if (&element) begin
                        sample <= sample + 1'b1;
                        whole <= sample == LAST_SAMPLE;
                    end
                end
                if (beat[64] && beat_ready) state <= START;
            end
            START: if (begins) begin
                state <= LINE;
                {half, whole, sample, element} <= 0;
                blocks <= blocks + 1;
            end
            LINE: if (line_done) state <= HEADER;
        endcase
        if (reset) {state, half, whole, sample, element, start, solving, write, blocks} <= 0;
    end

    // --- Delays of a line.
    wire [31:0] delay;
    wire delay_valid, delay_ready;
    receive_delays #(ELEMENTS) receive (clock, reset, start, depth, depth_step, across, pitch, delay_valid, delay_ready,
        delay);
    wire aligned_valid, aligned_ready, aligned_last;
    wire signed [BITS+11:0] aligned_re, aligned_im;
    reg [15:0] asked, aligned;     // samples of the line
    reg [3:0] asked_element;
    reg asks, asked_last, aligned_end;
    wire asked_now = delay_valid && delay_ready && &asked_element;
    wire aligned_now = aligned_valid && aligned_ready && aligned_last;
    delay_interpolate #(ELEMENTS, SAMPLES, BITS, PHASORS, 0) interpolate (clock, reset, asks, write, write_sample,
        write_element, write_word, start, first_position, first_cycles, step_position, step_cycles, rate, delay_valid,
        delay_ready, delay, 16'd0, aligned_valid, aligned_ready, aligned_last, aligned_re, aligned_im);
    assign line_done = aligned_now && aligned_end;
    always @(posedge clock) begin
        // A sample has many clocks.
        asked_last <= asked + 1'b1 == outputs;
        aligned_end <= aligned + 1'b1 == outputs;
        if (delay_valid && delay_ready) asked_element <= asked_element + 1'b1;
        if (asked_now) asked <= asked + 1'b1;
        if (asked_now && asked_last) asks <= 0;
        if (aligned_now) aligned <= aligned + 1'b1;
        if (start) asks <= 1;
        if (state == START || reset) {asked, asked_element, aligned, asks} <= 0;
    end

    // --- Words of 16 bits: counts, rounded, then saturated.
    localparam V = BITS + 12;
    wire [2*V-1:0] aligned_word = {aligned_re, aligned_im};
    wire word_ready;
    reg [2:1] moves, ends;
    wire word_valid = moves[2];
    assign aligned_ready = !word_valid || word_ready;
    genvar k;
    generate
        for (k = 0; k < 2; k = k + 1) begin : part
            reg signed [V-11:0] rounded;
            reg [15:0] count;
            wire unused_bits = &aligned_word[V*k +: 10];
            wire [V-27:0] above = rounded[V-11:16];
            wire fits = (above == {V-26{rounded[15]}}) && rounded[15:0] != 16'h8000;
            always @(posedge clock) if (aligned_ready) begin
                rounded <= {aligned_word[V*k+V-1], aligned_word[V*k+11 +: V-11]} + {{V-11{1'b0}}, aligned_word[V*k+10]};
                count <= fits ? rounded[15:0] : {rounded[V-11], {14{!rounded[V-11]}}, 1'b1};
            end
        end
    endgenerate
    always @(posedge clock) begin
        if (aligned_ready) begin
            moves <= {moves[1], aligned_valid};
            ends <= {ends[1], line_done};
        end
        if (reset) moves <= 0;
    end

    // --- MV, or another program.
    wire number_valid, number_ready, number_last, number_end, z_end, z_valid, z_ready;
    wire [31:0] number;
    wire [6:0] number_address;
    wire [4:0] exponent;
    wire [31:0] re, im;
    real_form #(FORM) form (clock, reset, 1'b1, line_loading, word_valid, word_ready, {part[1].count, part[0].count},
        ends[2], number_valid, number_ready, number, number_address, number_last, number_end, exponent);
    solver #(PROGRAM, 1024, RECIPROCALS) solver (clock, reset, 1'b1, line_first, number_valid, number_ready, number,
        number_address, number_last, number_end, exponent, z_valid, z_ready, z_end, re, im);
    assign line_solved = z_valid && z_ready && z_end;
    skid #(65) leaving (clock, reset, {z_end, im, re}, z_valid, z_ready, {m_axis_tlast, m_axis_tdata}, m_axis_tvalid,
        m_axis_tready);
endmodule
