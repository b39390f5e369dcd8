// Delay, linear interpolation and apodization of I/Q: an element a clock, 6 deep, with the bits of
// core/src/delay/iq/fixed.rs. See docs/fpga.md.
//
// Positions and carrier phases of a line are accumulators. Receive delays come from a table or a root outside, in
// the order [output sample][element].
module delay_interpolate #(
    parameter ELEMENTS = 16,       // from 2 on
    parameter SAMPLES = 280,       // of a record, from 3 on
    parameter BITS = 16,           // of a count
    parameter TABLE = "phasors.hex"
) (
    input wire clock,
    input wire reset,
    input wire enable,             // low: no receive delay is taken
    input wire record_write,       // not while a line is computed
    input wire [$clog2(SAMPLES)-1:0] record_sample,
    input wire [$clog2(ELEMENTS)-1:0] record_element,
    input wire [2*BITS-1:0] record_word,   // {re, im}
    input wire start,              // begins a line, at these two:
    input wire [51:0] first_position,      // of output sample 0, 2^-32 samples
    input wire [43:0] first_cycles,        // its phase, 2^-44 cycles
    input wire [51:0] step_position,       // from one output sample to the next
    input wire [43:0] step_cycles,
    input wire [27:0] rate,        // f_demod/fs, 2^-26
    input wire in_valid,
    output wire in_ready,
    input wire signed [31:0] in_delay,     // receive delay, 2^-18 samples
    input wire [15:0] in_weight,   // apodization, 2^-15; at most 1
    output wire out_valid,
    input wire out_ready,
    output wire out_last,          // the last element of an output sample
    output reg signed [BITS+11:0] re,      // 2^-11 of a count
    output reg signed [BITS+11:0] im
);
    localparam E = $clog2(ELEMENTS);
    localparam H = $clog2((SAMPLES + 1) / 2);
    localparam [E-1:0] LAST = ELEMENTS[E-1:0] - 1'b1;

    reg [2*BITS-1:0] even [0:(1<<(H+E))-1];
    reg [2*BITS-1:0] odd [0:(1<<(H+E))-1];
    reg [31:0] phasors [0:2047];   // {cosine, sine} of half a cycle, 2^-14
    initial $readmemh(TABLE, phasors);
    wire [E+H-1:0] record_address = {record_sample[H:1], record_element};
    always @(posedge clock) begin
        if (record_write && !record_sample[0]) even[record_address] <= record_word;
        if (record_write && record_sample[0]) odd[record_address] <= record_word;
    end

    reg [6:1] valid, last;
    assign out_valid = valid[6];
    assign out_last = last[6];
    wire advance = !out_valid || out_ready;
    assign in_ready = enable && advance && !start;
    wire taken = in_valid && in_ready;
    reg [E-1:0] element;
    wire last_element = element == LAST;
    always @(posedge clock) begin
        if (advance) begin
            valid <= {valid[5:1], taken};
            last <= {last[5:1], last_element};
        end
        if (reset) valid <= 0;
    end

    // --- 1: where the element is read, 2^-13 samples, and its phase, 2^-44 cycles.
    reg [51:0] position;
    reg [43:0] cycles, cycles_1, turn_1;
    reg [33:0] at_1;
    reg [E-1:0] element_1;
    reg [15:0] weight_1, weight_2, weight_3, weight_4, weight_5;
    wire signed [60:0] turn = in_delay * $signed({1'b0, rate});
    wire unused_1 = &{turn[60:44], position[18:0], in_delay[4:0]};
    always @(posedge clock) begin
        if (start) begin
            position <= first_position;
            cycles <= first_cycles;
            element <= 0;
        end else if (taken) begin
            element <= last_element ? {E{1'b0}} : element + 1'b1;
            if (last_element) begin
                position <= position + step_position;
                cycles <= cycles + step_cycles;
            end
        end
        if (advance) begin
            at_1 <= {position[51], position[51:19]} + {{7{in_delay[31]}}, in_delay[31:5]};
            // So that cutting the phase rounds.
            cycles_1 <= cycles + 44'h80000000;
            turn_1 <= turn[43:0];
            element_1 <= element;
            {weight_5, weight_4, weight_3, weight_2, weight_1} <= {weight_4, weight_3, weight_2, weight_1, in_weight};
        end
    end

    // --- 2: the samples on both sides; 0 outside of the record.
    wire [20:0] index = at_1[33:13], next = index + 1'b1;
    wire [43:0] phase = cycles_1 + turn_1;
    wire unused_2 = &{phase[31:0], next[0]};
    reg [2*BITS-1:0] even_2, odd_2;
    reg swap_2, first_2, second_2;
    reg [12:0] fraction_2;
    reg [11:0] phase_2;
    always @(posedge clock) if (advance) begin
        even_2 <= even[{next[H:1], element_1}];
        odd_2 <= odd[{index[H:1], element_1}];
        swap_2 <= index[0];
        first_2 <= index < SAMPLES[20:0];
        second_2 <= next < SAMPLES[20:0];
        fraction_2 <= at_1[12:0];
        phase_2 <= phase[43:32];
    end

    // --- 3: the sample between them, 2^-13 of a count, and the table. 4: their products.
    wire [2*BITS-1:0] earlier = first_2 ? (swap_2 ? odd_2 : even_2) : {2*BITS{1'b0}};
    wire [2*BITS-1:0] later = second_2 ? (swap_2 ? even_2 : odd_2) : {2*BITS{1'b0}};
    reg [31:0] phasor_3;
    reg negative_3, half_3;
    always @(posedge clock) if (advance) begin
        phasor_3 <= phasors[phase_2[11] ? -phase_2[10:0] : phase_2[10:0]];
        negative_3 <= phase_2[11];
        half_3 <= phase_2 == 12'h800;
    end
    wire signed [15:0] cosine = half_3 ? -16'sd16384 : phasor_3[31:16];
    wire signed [15:0] sine = half_3 ? 16'sd0 : negative_3 ? -phasor_3[15:0] : phasor_3[15:0];
    genvar k;
    generate
        for (k = 0; k < 2; k = k + 1) begin : part
            wire signed [BITS-1:0] a = earlier[BITS*k +: BITS], b = later[BITS*k +: BITS];
            wire signed [BITS:0] rise = {b[BITS-1], b} - {a[BITS-1], a};
            wire signed [BITS+14:0] risen = rise * $signed({1'b0, fraction_2});
            reg signed [BITS+12:0] between_3;
            reg signed [BITS+28:0] cosine_4, sine_4;
            wire unused = &{risen[BITS+14:BITS+13], cosine_4[BITS+28], cosine_4[15:0], sine_4[BITS+28], sine_4[15:0]};
            always @(posedge clock) if (advance) begin
                between_3 <= {a, 13'd0} + risen[BITS+12:0];
                cosine_4 <= between_3 * cosine;
                sine_4 <= between_3 * sine;
            end
        end
    endgenerate

    // --- 5: the rotated sample, each product truncated. 6: its weight.
    reg signed [BITS+11:0] re_5, im_5;
    wire signed [BITS+28:0] re_weighted = re_5 * $signed({1'b0, weight_5});
    wire signed [BITS+28:0] im_weighted = im_5 * $signed({1'b0, weight_5});
    wire unused_6 = &{re_weighted[BITS+28:BITS+27], re_weighted[14:0], im_weighted[BITS+28:BITS+27], im_weighted[14:0]};
    always @(posedge clock) if (advance) begin
        re_5 <= part[1].cosine_4[BITS+27:16] - part[0].sine_4[BITS+27:16];
        im_5 <= part[1].sine_4[BITS+27:16] + part[0].cosine_4[BITS+27:16];
        re <= re_weighted[BITS+26:15];
        im <= im_weighted[BITS+26:15];
    end
endmodule
