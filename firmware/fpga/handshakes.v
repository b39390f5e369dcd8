// For proofs of the streams, by `firmware/fpga/handshakes`: a word that is offered stays until it is taken, whatever
// comes in; a skid buffer loses and doubles none; a register's write and its read have one answer each.
module held #(
    parameter BITS = 64
) (
    input wire clock,
    input wire reset,
    input wire valid,
    input wire ready,
    input wire [BITS-1:0] data
);
    reg waits = 0;
    reg [BITS-1:0] before;
    always @(posedge clock) begin
        waits <= valid && !ready && !reset;
        before <= data;
    end
    always @* if (waits) assert (valid && data == before);
endmodule

// As many words leave as come, but for up to WITHIN in between: then none is taken, and without one none is offered.
module counted #(
    parameter WITHIN = 2
) (
    input wire clock,
    input wire reset,
    input wire taken,
    input wire given,
    input wire ready,
    input wire valid
);
    reg [3:0] count = 0;
    reg began = 0;
    always @(posedge clock) begin
        count <= reset ? 4'd0 : count + taken - given;
        began <= began || reset;
    end
    always @* if (began) assert (count <= WITHIN && ready == (count != WITHIN) && valid == (count != 0));
endmodule

module skid_held (input clock, reset, in_valid, out_ready, input [7:0] in);
    wire in_ready, out_valid;
    wire [7:0] out;
    skid #(8) dut (clock, reset, in, in_valid, in_ready, out, out_valid, out_ready);
    held #(8) stays (clock, reset, out_valid, out_ready, out);
    counted #(2) all (clock, reset, in_valid && in_ready, out_valid && out_ready, in_ready, out_valid);
endmodule

module credits_held (input clock, reset, begins, in_valid, out_ready, input [7:0] in);
    wire room, out_valid;
    wire [7:0] out;
    credits #(8) dut (clock, reset, room, begins, in_valid, in, out, out_valid, out_ready);
    held #(8) stays (clock, reset, out_valid, out_ready, out);
endmodule

module registers_held (
    input clock, reset, aw_valid, w_valid, b_ready, ar_valid, r_ready,
    input [3:0] aw, ar, strobe,
    input [31:0] w, status
);
    wire aw_ready, w_ready, b_valid, ar_ready, r_valid;
    wire [1:0] b, r_code;
    wire [31:0] r;
    wire [127:0] values;
    registers #(4) dut (clock, reset, aw, aw_valid, aw_ready, w, strobe, w_valid, w_ready, b, b_valid, b_ready, ar, ar_valid,
        ar_ready, r, r_code, r_valid, r_ready, status, values);
    held #(34) stays (clock, reset, r_valid, r_ready, {r_code, r});
    held #(2) answer (clock, reset, b_valid, b_ready, b);
    counted #(1) writes (clock, reset, aw_valid && aw_ready, b_valid && b_ready, !b_valid, b_valid);
    counted #(1) reads (clock, reset, ar_valid && ar_ready, r_valid && r_ready, !r_valid, r_valid);
    always @* assert (aw_ready == w_ready && !(aw_ready && !(aw_valid && w_valid)));
endmodule

module das_tree_held (input clock, reset, enable, in_valid, out_ready, input [63:0] words);
    wire in_ready, out_valid;
    wire [15:0] mean;
    das_tree #(4, 8) dut (clock, reset, enable, in_valid, in_ready, words, out_valid, out_ready, mean);
    held #(16) stays (clock, reset, out_valid, out_ready, mean);
endmodule

module covariance_mac_held (input clock, reset, enable, in_valid, in_last, out_ready, input [15:0] a, b);
    wire in_ready, out_valid;
    wire [19:0] re, im;
    covariance_mac #(8, 20) dut (clock, reset, enable, in_valid, in_ready, in_last, a, b, out_valid, out_ready, re, im);
    held #(40) stays (clock, reset, out_valid, out_ready, {re, im});
endmodule

module packer_held (
    input clock, reset, enable, start, s_valid, waits, m_ready,
    input [15:0] beam,
    input [7:0] epoch,
    input [23:0] s,
    input [1:0] user
);
    wire s_ready, m_valid, m_last;
    wire [63:0] m;
    packer #(8, 3, 4) dut (clock, reset, enable, start, beam, epoch, s, user, s_valid, s_ready, waits, m, m_valid, m_ready,
        m_last);
    held #(65) stays (clock, reset, m_valid, m_ready, {m_last, m});
endmodule

module delay_interpolate_held (
    input clock, reset, enable, write, start, in_valid, out_ready,
    input [2:0] sample,
    input [1:0] element,
    input [31:0] word, delay,
    input [51:0] first_position, step_position,
    input [43:0] first_cycles, step_cycles,
    input [27:0] rate,
    input [15:0] weight
);
    wire in_ready, out_valid, last;
    wire [27:0] re, im;
    delay_interpolate #(4, 8) dut (clock, reset, enable, write, sample, element, word, start, first_position, first_cycles,
        step_position, step_cycles, rate, in_valid, in_ready, delay, weight, out_valid, out_ready, last, re, im);
    held #(57) stays (clock, reset, out_valid, out_ready, {last, re, im});
endmodule

// A new line breaks off the one before.
module receive_delays_held (input clock, reset, start, out_ready, input [34:0] depth, depth_step, across, pitch);
    wire out_valid;
    wire [31:0] delay;
    receive_delays #(4) dut (clock, reset, start, depth, depth_step, across, pitch, out_valid, out_ready, delay);
    held #(32) stays (clock, reset || start, out_valid, out_ready, delay);
endmodule

module real_form_held (input clock, reset, enable, in_valid, in_end, out_ready, input [15:0] loading, input [31:0] word);
    wire in_ready, out_valid, last, line_end;
    wire [31:0] number;
    wire [6:0] address;
    wire [4:0] exponent;
    real_form dut (clock, reset, enable, loading, in_valid, in_ready, word, in_end, out_valid, out_ready, number, address,
        last, line_end, exponent);
    held #(40) stays (clock, reset, out_valid, out_ready, {last, number, address});
endmodule

module solver_held (
    input clock, reset, enable, in_valid, in_last, in_end, out_ready,
    input [8:0] first,
    input [31:0] number,
    input [6:0] address,
    input [4:0] exponent
);
    wire in_ready, out_valid, out_end;
    wire [31:0] re, im;
    solver dut (clock, reset, enable, first, in_valid, in_ready, number, address, in_last, in_end, exponent, out_valid, out_ready,
        out_end, re, im);
    held #(65) stays (clock, reset, out_valid, out_ready, {out_end, re, im});
endmodule
