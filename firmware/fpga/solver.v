// Sums of products of numbers of 32 bits, 26 after the point, as a program says: for each of eight samples before the
// next sum begins. With MV's program LDLt, its solutions, and z; before it, with that of rank 1, power iteration. A sample
// takes as many clocks as the program has terms.
// See docs/fpga.md.
module solver #(
    parameter PROGRAM = "solver.hex",
    parameter TERMS = 1024,        // at most, of the program
    parameter RECIPROCALS = "reciprocals.hex"
) (
    input wire clock,
    input wire reset,
    input wire enable,             // low: no number is taken
    input wire [9:0] first,        // term with which a method's program begins, while samples of it are inside
    input wire in_valid,
    output wire in_ready,
    input wire [31:0] in_number,
    input wire [6:0] in_address,
    input wire in_last,            // of the sample
    input wire in_end,             // with the last one: of the line
    input wire [4:0] in_exponent,  // with the last one: 0 without power, else up to 20
    output wire out_valid,
    input wire out_ready,
    output wire out_end,           // of the line
    output reg signed [31:0] re,   // 2^-10 of a word of real_form
    output reg signed [31:0] im
);
    // --- Two banks of eight samples of 128 numbers; an exponent is above each number.
    (* no_rw_check *) reg [35:0] memory_a [0:2047], memory_b [0:2047];
    reg [4:0] exponents [0:15];
    reg [1:0] full, solved;
    reg full_end [0:1];
    reg [2:0] count [0:1];         // of a bank's samples, less one
    reg in_bank, bank;
    reg [2:0] in_slot;
    reg writes;
    wire [10:0] address_13;
    wire [35:0] number_13;
    assign in_ready = enable && !full[in_bank] && !writes;
    wire taken = in_valid && in_ready;
    wire [10:0] write_address = writes ? address_13 : {in_bank, in_slot, in_address};
    wire [35:0] write_number = writes ? number_13 : {4'd0, in_number};
    wire fills = taken && in_last && (in_end || &in_slot);
    wire finished;
    always @(posedge clock) begin
        if (writes || taken) begin
            memory_a[write_address] <= write_number;
            memory_b[write_address] <= write_number;
        end
        if (taken && in_last) begin
            exponents[{in_bank, in_slot}] <= in_exponent;
            in_slot <= in_end ? 3'd0 : in_slot + 1'b1;
        end
        if (fills) begin
            full_end[in_bank] <= in_end;
            count[in_bank] <= in_slot;
            in_bank <= !in_bank;
        end
        full <= (full | {fills && in_bank, fills && !in_bank}) & ~{finished && bank, finished && !bank};
        if (reset) begin
            full <= 0;
            {in_bank, in_slot} <= 0;
        end
    end

    // --- Terms, in the order [sum][sample][term]. The length of a sum comes with the one before; it is 0 at the end.
    reg [32:0] terms [0:TERMS-1];
    initial $readmemh(PROGRAM, terms);
    reg [9:0] place, start;
    reg [3:0] length, term;
    reg [2:0] slot;
    reg running;
    reg [4:0] drained;
    wire last_term = term == length;
    reg [28:0] term_1;
    reg [3:0] next_1, next_2;
    assign finished = drained == 5'd31;
    always @(posedge clock) begin
        if (!running) begin
            if (drained != 0) drained <= drained + 1'b1;
            running <= full[bank] && !solved[bank] && drained == 0;
            place <= first;
            start <= first;
            slot <= 0;
            term <= 1;
            length <= 1;
        end else begin
            term <= last_term ? 4'd1 : term + 1'b1;
            place <= last_term && slot != 7 ? start : place + 1'b1;
            if (last_term) slot <= slot + 1'b1;
            if (last_term && slot == 7) begin
                start <= place + 1'b1;
                length <= next_2;
                if (next_2 == 0) begin
                    running <= 0;
                    drained <= 16;
                end
            end
        end
        if (finished) bank <= !bank;
        if (reset) {running, drained, bank} <= 0;
    end

    // --- 1: the term. 3, 4: its numbers. 8: their product. 9: the sum. 12: the sum, shifted and rounded.
    // 13: saturated, and then in memory.
    localparam TO = 14, UNIT = 21, NEGATIVE = 22, LAST = 23, UP = 24, TWO = 25, KEEP = 26, RECIPROCAL = 27, OUTPUT = 28;
    reg [28:0] flags [2:13];       // the term, from place TO on
    reg [2:0] slots [1:13];
    reg [12:1] valid;
    reg [35:0] a_3, b_3;
    reg signed [31:0] a_4, b_4;
    reg [3:0] keeps [4:12], ups [4:9];
    wire signed [63:0] product_8;
    reg signed [66:0] sum_9;
    reg fresh;
    reg signed [56:0] shifted_10, shifted_11, rounded_12;
    reg [1:0] shift_10;
    reg [35:0] result_13;
    integer k;
    multiply #(32, 32) multiplier (clock, a_4, flags[4][UNIT] ? 32'sh4000000 : b_4, product_8);
    wire [3:0] shift_9 = ~ups[9];
    wire fits = &rounded_12[56:31] || !(|rounded_12[56:31]);
    wire [31:0] sum_12 = fits ? rounded_12[31:0] : {rounded_12[56], {31{!rounded_12[56]}}};

    // Reciprocals: the leading zeros of 27 bits, to 15, and 10 bits behind the first one.
    reg [16:0] reciprocals [0:1023];
    initial $readmemh(RECIPROCALS, reciprocals);
    wire [26:0] coarse = a_4[26:19] == 0 ? {a_4[18:0], 8'd0} : a_4[26:0];
    reg [26:0] mantissa_5;
    reg [1:0] zeros_5;
    wire [26:0] fine = mantissa_5[26:25] == 0 ? {mantissa_5[24:0], 2'd0} : mantissa_5;
    wire unused = &fine[14:0];
    reg [9:0] index_6;
    reg [3:0] zeros [6:12];
    reg [16:0] reciprocal_7, reciprocal_8, reciprocal_9, reciprocal_10, reciprocal_11, reciprocal_12;

    always @(posedge clock) begin
        {next_1, term_1} <= terms[place];
        next_2 <= next_1;
        flags[2] <= term_1;
        slots[1] <= slot;
        for (k = 3; k <= 13; k = k + 1) flags[k] <= flags[k-1];
        for (k = 2; k <= 13; k = k + 1) slots[k] <= slots[k-1];
        a_3 <= memory_a[{bank, slots[2], flags[2][6:0]}];
        b_3 <= memory_b[{bank, slots[2], flags[2][13:7]}];
        a_4 <= a_3[31:0];
        b_4 <= b_3[31:0];
        keeps[4] <= a_3[35:32];
        ups[4] <= b_3[35:32];
        ups[5] <= (flags[4][UNIT] ? 4'd0 : ups[4]) | {2'd0, flags[4][UP], 1'b0};
        for (k = 5; k <= 12; k = k + 1) keeps[k] <= keeps[k-1];
        for (k = 6; k <= 9; k = k + 1) ups[k] <= ups[k-1];
        if (valid[8]) begin
            sum_9 <= (fresh ? 67'sd0 : sum_9) + ({67{flags[8][NEGATIVE]}} ^ {{3{product_8[63]}}, product_8})
                + {66'd0, flags[8][NEGATIVE]};
            fresh <= flags[8][LAST];
        end
        shifted_10 <= $signed(sum_9[66:10]) >>> {shift_9[3:2], 2'd0};
        shift_10 <= shift_9[1:0];
        shifted_11 <= shifted_10 >>> shift_10;
        rounded_12 <= {shifted_11[56], shifted_11[56:1]} + {56'd0, shifted_11[0]};

        mantissa_5 <= coarse[26:23] == 0 ? {coarse[22:0], 4'd0} : coarse;
        zeros_5 <= {a_4[26:19] == 0, coarse[26:23] == 0};
        index_6 <= fine[26] ? fine[25:16] : fine[24:15];
        zeros[6] <= {zeros_5, mantissa_5[26:25] == 0, !fine[26]};
        for (k = 7; k <= 12; k = k + 1) zeros[k] <= zeros[k-1];
        reciprocal_7 <= reciprocals[index_6];
        {reciprocal_12, reciprocal_11, reciprocal_10, reciprocal_9, reciprocal_8} <=
            {reciprocal_11, reciprocal_10, reciprocal_9, reciprocal_8, reciprocal_7};

        result_13 <= flags[12][RECIPROCAL] ? {zeros[12], 6'd0, reciprocal_12, 9'd0}
            : {flags[12][KEEP] ? keeps[12] : 4'd0, flags[12][TWO] ? 5'd0 : sum_12[31:27], sum_12[26:0]};
        valid <= {valid[11:1], running};
        writes <= valid[12] && flags[12][LAST];
        if (reset) begin
            valid <= 0;
            writes <= 0;
            fresh <= 1;
        end
    end
    assign address_13 = {bank, slots[13], flags[13][TO +: 7]};
    assign number_13 = result_13;

    // --- The outputs of a bank.
    reg [31:0] solved_re [0:15], solved_im [0:15];
    reg [4:0] solved_exponents [0:15];
    reg [2:0] solved_count [0:1];
    reg solved_end [0:1];
    reg out_bank;
    reg [2:0] out_slot;
    reg signed [31:0] re_1, im_1, re_2, im_2, re_3, im_3;
    reg [4:0] shift_1;
    reg [1:0] shift_2;
    reg [4:1] moves, ends;
    assign out_valid = moves[4];
    assign out_end = ends[4];
    wire advance = !out_valid || out_ready;
    wire sends = advance && solved[out_bank];
    wire last_sent = out_slot == solved_count[out_bank];
    wire [4:0] exponent = solved_exponents[{out_bank, out_slot}];
    wire powered = exponent != 0;
    always @(posedge clock) begin
        if (writes && flags[13][OUTPUT]) begin
            if (flags[13][TO]) solved_re[{bank, slots[13]}] <= result_13[31:0];
            else solved_im[{bank, slots[13]}] <= result_13[31:0];
            solved_exponents[{bank, slots[13]}] <= exponents[{bank, slots[13]}];
        end
        if (finished) begin
            solved_count[bank] <= count[bank];
            solved_end[bank] <= full_end[bank];
        end
        if (sends) begin
            out_slot <= last_sent ? 3'd0 : out_slot + 1'b1;
            if (last_sent) out_bank <= !out_bank;
        end
        solved <= (solved | {finished && bank, finished && !bank})
            & ~{sends && last_sent && out_bank, sends && last_sent && !out_bank};
        if (advance) begin
            moves <= {moves[3:1], sends};
            ends <= {ends[3:1], last_sent && solved_end[out_bank]};
            re_1 <= powered ? solved_re[{out_bank, out_slot}] : 32'd0;
            im_1 <= powered ? solved_im[{out_bank, out_slot}] : 32'd0;
            shift_1 <= 5'd23 - exponent;
            re_2 <= re_1 >>> {shift_1[4:2], 2'd0};
            im_2 <= im_1 >>> {shift_1[4:2], 2'd0};
            shift_2 <= shift_1[1:0];
            re_3 <= re_2 >>> shift_2;
            im_3 <= im_2 >>> shift_2;
            re <= {re_3[31], re_3[31:1]} + {31'd0, re_3[0]};
            im <= {im_3[31], im_3[31:1]} + {31'd0, im_3[0]};
        end
        if (reset) begin
            solved <= 0;
            {moves, out_bank, out_slot} <= 0;
        end
    end
endmodule
