// Receive delays of a straight line from a linear array, for delay_interpolate: (sqrt(z^2 + d^2) - z), with z the depth
// and d an element's distance across, in the order [output sample][element]. Roots have 11 bits after the point, by
// digits; UNITS of them at a time, each in ROOT + 2 clocks. See docs/fpga.md.
module receive_delays #(
    parameter ELEMENTS = 16,       // from 2 on
    parameter ROOT = 26,           // bits of a root
    parameter UNITS = 2
) (
    input wire clock,
    input wire reset,
    input wire start,              // begins a line, at these, which stay:
    input wire [ROOT+8:0] depth,   // of output sample 0, 2^-20 samples of path
    input wire [ROOT+8:0] depth_step,
    input wire [ROOT+8:0] across,  // of element 0, signed
    input wire [ROOT+8:0] pitch,
    output wire out_valid,
    input wire out_ready,
    output wire [31:0] out_delay   // 2^-18 samples
);
    localparam W = ROOT + 9;
    localparam E = $clog2(ELEMENTS);
    localparam U = UNITS > 1 ? $clog2(UNITS) : 1;
    localparam C = $clog2(ROOT + 1);
    localparam [E-1:0] LAST = ELEMENTS[E-1:0] - 1'b1;
    localparam [U-1:0] LAST_UNIT = UNITS[U-1:0] - 1'b1;

    // --- Squares: of the depth, then of each element's distance.
    reg [W-1:0] z, d;
    reg [E-1:0] element;
    reg [2:0] wait_square;
    reg running, of_depth;
    reg [2*ROOT-1:0] depth_square;
    reg signed [ROOT-1:0] chosen, factor;
    wire signed [2*ROOT-1:0] square;
    multiply #(ROOT, ROOT) multiplier (clock, factor, factor, square);
    reg [U-1:0] unit, out_unit;
    wire [UNITS-1:0] idle, done;
    wire [32*UNITS-1:0] delays;
    wire squared = wait_square == 6;
    wire loads = running && squared && !of_depth && idle[unit];
    always @(posedge clock) begin
        chosen <= of_depth ? z[W-1:9] : d[W-1:9];
        factor <= chosen;
        if (!squared) wait_square <= wait_square + 1'b1;
        if (running && squared && of_depth) begin
            depth_square <= square;
            of_depth <= 0;
            wait_square <= 0;
        end
        if (loads) begin
            unit <= unit == LAST_UNIT ? {U{1'b0}} : unit + 1'b1;
            element <= element == LAST ? {E{1'b0}} : element + 1'b1;
            d <= element == LAST ? across : d + pitch;
            wait_square <= 0;
            if (element == LAST) begin
                z <= z + depth_step;
                of_depth <= 1;
            end
        end
        if (out_valid && out_ready) out_unit <= out_unit == LAST_UNIT ? {U{1'b0}} : out_unit + 1'b1;
        if (start) begin
            z <= depth;
            d <= across;
            running <= 1;
        end
        if (start || reset) {unit, out_unit, element, wait_square} <= 0;
        if (start || reset) of_depth <= 1;
        if (reset) running <= 0;
    end
    assign out_valid = done[out_unit];
    assign out_delay = delays[32*out_unit +: 32];

    // --- Roots, two bits of the square a clock.
    genvar k;
    generate
        for (k = 0; k < UNITS; k = k + 1) begin : digits
            reg [2*ROOT-1:0] rest;
            reg [ROOT-1:0] root, least;
            reg [ROOT+1:0] remainder;
            reg [C-1:0] left;
            reg busy;
            wire [ROOT+1:0] next = {remainder[ROOT-1:0], rest[2*ROOT-1:2*ROOT-2]};
            wire [ROOT+2:0] reduced = {1'b0, next} - {1'b0, root, 2'b01};
            wire [ROOT-1:0] apart = root - least;
            wire unused = &{remainder[ROOT+1:ROOT], apart[ROOT-1:24]};
            assign idle[k] = !busy;
            assign done[k] = busy && left == 0;
            assign delays[32*k +: 32] = {1'b0, apart[23:0], 7'd0};
            always @(posedge clock) begin
                if (busy && left != 0) begin
                    rest <= rest << 2;
                    root <= {root[ROOT-2:0], !reduced[ROOT+2]};
                    remainder <= reduced[ROOT+2] ? next : reduced[ROOT+1:0];
                    left <= left - 1'b1;
                end
                if (done[k] && out_ready && out_unit == k[U-1:0]) busy <= 0;
                if (loads && unit == k[U-1:0]) begin
                    rest <= depth_square + square;
                    root <= 0;
                    remainder <= 0;
                    left <= ROOT[C-1:0];
                    least <= z[W-1:9];
                    busy <= 1;
                end
                if (start || reset) busy <= 0;
            end
        end
    endgenerate
endmodule
